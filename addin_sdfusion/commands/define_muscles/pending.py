"""The pending table: links of what is picked, task points, markers and wrap surfaces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from ...muscles.edits import renumbered
from ...muscles.point_names import natural_key
from ...muscles.rows import MarkerRow, MuscleTable, TaskRow, WrapRow, WrapUse
from ...robot.model.pose import Vector3
from ...robot.model.robot import WORLD

Role = Literal["task", "marker"]
HANDLE = "pick:"
"""How handles of picked things begin that are no construction points."""


@dataclass(frozen=True, slots=True)
class Pick:
    """A place that the user has clicked.

    Attributes:
        position: In the root frame, in [m].
        occurrence: Path of the occurrence that was clicked.
        entity: What the construction point is that was clicked; else a handle of what was.
        part: What it is called, for messages.
        problem: Why it cannot be used; empty if it can.
        face: The cylinder or sphere, if a surface was picked.
    """

    position: Vector3
    occurrence: str
    entity: str
    part: str
    problem: str = ""
    face: WrapRow | None = None


class Pending:
    """The pending table, but for the chosen muscle.

    Attributes:
        before: The table as the design has it.
        table: The table as it will be after OK.
        link_of: The link of each occurrence's path.
        links: Names of all links.
        muscle: Name of the muscle that picks go to; empty if there is none.
        link: The link chosen for picks; that of the picked part if empty.
        wrap: Name of the wrap surface that is looked at.
        message: What happened last.
    """

    muscle: str

    def __init__(self, table: MuscleTable, link_of: Mapping[str, str], note: str = "") -> None:
        self.before = table
        self.table = renumbered(table)
        self.link_of = link_of
        self.links = sorted(set(link_of.values()) - {WORLD}, key=natural_key)
        self.link = ""
        self.wrap = table.wraps[0].name if table.wraps else ""
        self.message = note

    def pick_other(self, pick: Pick, role: Role) -> None:
        """A task point or marker, with a name of its own."""
        link = self._link(pick)
        if link is None:
            return
        if self._taken(pick):
            pick = replace(pick, entity="")
        taken = {row.name for row in (self.table.tasks if role == "task" else self.table.markers)}
        names = (f"{link}_{n}" if n else link for n in range(len(taken) + 1))
        name = next(name for name in names if name not in taken)
        place = (pick.position,)
        if role == "task":
            task = TaskRow(name, link, *place, entity=pick.entity, occurrence=pick.occurrence)
            self.table = replace(self.table, tasks=(*self.table.tasks, task))
        else:
            marker = MarkerRow(name, link, *place, pick.entity, pick.occurrence)
            self.table = replace(self.table, markers=(*self.table.markers, marker))
        self.message = f"{'Task point' if role == 'task' else 'Marker'} {name} is on link {link}."

    def pick_surface(self, pick: Pick) -> None:
        """A wrap surface; one that is there already is looked at."""
        there = [wrap for wrap in self.table.wraps if wrap.entity == pick.entity]
        if there:
            self.wrap = there[0].name
            self.message = f"That face is wrap surface {self.wrap} already."
            return
        link = self._link(pick)
        if link is None or pick.face is None:
            return
        taken = {wrap.name for wrap in self.table.wraps}
        names = (f"{link}_{pick.face.shape}{n or ''}" for n in range(len(taken) + 1))
        self.wrap = next(name for name in names if name not in taken)
        row = replace(pick.face, name=self.wrap, link=link)
        self.table = replace(self.table, wraps=(*self.table.wraps, row))
        size = f"a {row.shape} of radius {1000 * row.radius:.4g} mm"
        self.message = f"Wrap surface {self.wrap} is {size} on link {link}."

    def _link(self, pick: Pick) -> str | None:
        """The link that a pick belongs to; None, with a message, if there is none."""
        if pick.problem:
            self.message = pick.problem
            return None
        link = self.link or self.link_of.get(pick.occurrence, "")
        if not link:
            self.message = (
                f"{pick.part} belongs to no link: put it into a rigid group EXPORT_<link>, or "
                "choose a link in the drop-down and pick again."
            )
            return None
        return link

    def _taken(self, pick: Pick) -> bool:
        """Whether a construction point is in the table already: it can be one thing only."""
        if pick.entity.startswith(HANDLE):
            return False
        table = self.table
        taken = {row.entity for rows in (table.points, table.tasks) for row in rows}
        return pick.entity in taken | {row.entity for row in table.markers}

    # Wrap surfaces, task points, markers

    def wrap_row(self) -> WrapRow | None:
        """The wrap surface that is looked at."""
        return next((wrap for wrap in self.table.wraps if wrap.name == self.wrap), None)

    def change_wrap(self, edit: Callable[[WrapRow], WrapRow | None]) -> None:
        """Other properties of the wrap surface that is looked at; None deletes it."""
        edited = [(edit(w) if w.name == self.wrap else w) for w in self.table.wraps]
        self.table = replace(self.table, wraps=tuple(w for w in edited if w is not None))
        if self.wrap_row() is None:
            self.wrap = self.table.wraps[0].name if self.table.wraps else ""

    def rename_wrap(self, name: str) -> None:
        """Another name for the wrap surface; a name that is taken or empty is refused."""
        name = name.strip()
        if name == self.wrap:
            return
        if not name or any(wrap.name == name for wrap in self.table.wraps):
            self.message = f"There is a wrap surface {name!r} already; choose another name."
            return
        before, self.wrap = self.wrap, name
        renamed = [replace(w, name=name) if w.name == before else w for w in self.table.wraps]
        self.table = replace(self.table, wraps=tuple(renamed))

    def add_use(self) -> None:
        """The chosen muscle wraps over the surface, after its first point."""
        points = self.table.points_of(self.muscle)
        if self.wrap_row() is None or len(points) < 2:
            self.message = "Pick a face, and choose a muscle with two points on the first tab."
            return
        use = WrapUse(self.muscle, points[0].number)
        self.change_wrap(lambda wrap: replace(wrap, muscles=(*wrap.muscles, use)))

    def change_use(self, index: int, edit: Callable[[WrapUse], WrapUse | None]) -> None:
        """One way of a muscle over the surface; None deletes it."""

        def changed(wrap: WrapRow) -> WrapRow:
            uses = [edit(use) if i == index else use for i, use in enumerate(wrap.muscles)]
            return replace(wrap, muscles=tuple(use for use in uses if use is not None))

        self.change_wrap(changed)

    def others(self) -> tuple[TaskRow | MarkerRow, ...]:
        """Task points, then markers."""
        return *self.table.tasks, *self.table.markers

    def change_other(self, index: int, *, name: str | None = None, link: str | None = None) -> None:
        """Another name or link of a task point or marker."""
        row = self.others()[index]
        new = row if name is None else replace(row, name=name.strip())
        if link is not None and link != row.link:
            new = replace(new, link=link)
            if row.made:  # made anew in the other link's component
                new = replace(new, entity="", occurrence="", made=False)
        self._set_others([new if i == index else r for i, r in enumerate(self.others())])

    def delete_other(self, index: int) -> None:
        """The task point or marker goes."""
        if not 0 <= index < len(self.others()):
            self.message = "Select a task point or marker in the table first."
            return
        self._set_others([row for i, row in enumerate(self.others()) if i != index])

    def _set_others(self, rows: list[TaskRow | MarkerRow]) -> None:
        self.table = replace(
            self.table,
            tasks=tuple(row for row in rows if isinstance(row, TaskRow)),
            markers=tuple(row for row in rows if isinstance(row, MarkerRow)),
        )
