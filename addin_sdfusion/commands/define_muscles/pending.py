"""Pending table of muscles: the state of the dialog, apart from Fusion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from ...muscles.edits import (
    delete_muscle,
    delete_point,
    duplicate_point,
    insert_point,
    move_point,
    new_muscle_name,
    next_color,
    rename_muscle,
    renumbered,
    set_link,
    set_position,
    with_muscle,
)
from ...muscles.mirror import Plane, mirror_muscle, other_side
from ...muscles.point_names import natural_key
from ...muscles.rows import (
    MarkerRow,
    MuscleRow,
    MuscleTable,
    TaskRow,
    ViaPointRow,
    WrapRow,
)
from ...robot.finding import Finding
from ...robot.model.pose import Vector3
from ...robot.model.robot import WORLD
from ...snapshot import WrapUse

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


class PendingTable:
    """The pending table, and what the user looks at.

    Attributes:
        before: The table as the design has it.
        table: The table as it will be after OK.
        link_of: The link of each occurrence's path.
        links: Names of all links.
        muscle: Name of the muscle that picks go to; empty if there is none.
        insert_at: Where in the muscle the next pick goes; at the end if None.
        link: The link chosen for picks; that of the picked part if empty.
        wrap: Name of the wrap surface that is looked at.
        message: What happened last.
    """

    def __init__(self, table: MuscleTable, link_of: Mapping[str, str], note: str = "") -> None:
        self.before = table
        self.table = renumbered(table)
        self.link_of = link_of
        self.links = sorted(set(link_of.values()) - {WORLD}, key=natural_key)
        self.muscle = table.rows[0].name if table.rows else ""
        self.insert_at: int | None = None
        self.link = ""
        self.wrap = table.wraps[0].name if table.wraps else ""
        self.message = note

    # Picks

    def pick_point(self, pick: Pick) -> None:
        """A via point of the chosen muscle, which is made if there is none."""
        link = self._link(pick)
        if link is None:
            return
        name = self.muscle or new_muscle_name(self.table)
        if self._taken(pick):
            pick = replace(pick, entity="")
        point = ViaPointRow(name, -1, link, pick.position, pick.entity, pick.occurrence)
        self.table = insert_point(self.table, point, self.insert_at)
        index = len(self.table.points_of(name)) - 1 if self.insert_at is None else self.insert_at
        self.muscle = name
        if self.insert_at is not None:
            self.insert_at += 1
        number = self.table.points_of(name)[index].number
        self.message = f"Point {number} of {name} is on link {link}."

    def pick_other(self, pick: Pick, role: Role) -> None:
        """A task point or marker, with a name of its own."""
        link = self._link(pick)
        if link is None:
            return
        if self._taken(pick):
            pick = replace(pick, entity="")
        table = self.table
        taken = {row.name for row in (table.tasks if role == "task" else table.markers)}
        names = (f"{link}_{n}" if n else link for n in range(len(taken) + 1))
        name = next(name for name in names if name not in taken)
        point = name, link, pick.position, pick.entity, pick.occurrence
        if role == "task":
            self.table = replace(table, tasks=(*table.tasks, TaskRow(*point)))
        else:
            self.table = replace(table, markers=(*table.markers, MarkerRow(*point)))
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
        """One muscle's wrap over the surface; None deletes it."""

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

    # The chosen muscle

    def choose(self, muscle: str) -> None:
        """Picks go to that muscle; to a new one if empty."""
        if not muscle:
            muscle = new_muscle_name(self.table)
            self.table = with_muscle(self.table, MuscleRow(muscle, next_color(self.table)))
            self.message = f"{muscle} is new: pick its points, in order."
        self.muscle = muscle
        self.insert_at = None

    def rename(self, name: str, muscle: str | None = None) -> None:
        """Another name for a muscle, the chosen one if None; what is taken or empty is refused."""
        name, old = name.strip(), self.muscle if muscle is None else muscle
        if not old or name == old:
            return
        if not name or not name.isprintable():
            self.message = "A muscle needs a name of letters that can be seen."
        elif self.table.row(name) is not None:
            self.message = f"There is a muscle {name} already; choose another name."
        else:
            self.table = rename_muscle(self.table, old, name)
            self.muscle = name if old == self.muscle else self.muscle

    def delete(self) -> None:
        """The chosen muscle goes, with its points."""
        if self.muscle:
            self.table = delete_muscle(self.table, self.muscle)
            self.message = f"{self.muscle} is deleted."
            self.muscle = self.table.rows[0].name if self.table.rows else ""
            self.insert_at = None

    def change(self, edit: Callable[[MuscleRow], MuscleRow], muscle: str | None = None) -> None:
        """Other properties of a muscle, the chosen one if None."""
        row = self.table.row(self.muscle if muscle is None else muscle)
        if row is not None:
            self.table = with_muscle(self.table, edit(row))

    def edit_point(self, what: str, index: int) -> int:
        """What a button below the table of points does.

        Args:
            what: `up`, `down`, `insert`, `duplicate` or `delete`.
            index: Of the selected point; -1 if none is.

        Returns:
            The index of the point that is selected then; -1 for none.
        """
        count = len(self.table.points_of(self.muscle))
        if what == "insert" and self.insert_at is not None:
            self.insert_at = None
            self.message = "The next points come at the end."
            return index
        if not 0 <= index < count:
            self.message = "Select a point in the table first."
            return -1
        if what == "insert":
            self.insert_at = index
            self.message = f"The next points come before point {self._number(index)}."
            return index
        self.insert_at = None
        if what == "duplicate":
            self.table = duplicate_point(self.table, self.muscle, index)
            return index + 1
        if what == "delete":
            self.table = delete_point(self.table, self.muscle, index)
            return min(index, count - 2)
        by = -1 if what == "up" else 1
        self.table = move_point(self.table, self.muscle, index, by)
        return min(max(index + by, 0), count - 1)

    def point_link(self, index: int, link: str) -> None:
        """A point of the chosen muscle fixed to another link."""
        if self.table.points_of(self.muscle)[index].link != link:
            self.table = set_link(self.table, self.muscle, index, link)
            self.message = f"Point {self._number(index)} of {self.muscle} is on link {link}."

    def point_position(self, index: int, position: Vector3) -> None:
        """A point of the chosen muscle put to another place, in [m]."""
        self.table = set_position(self.table, self.muscle, index, position)
        self.message = f"Point {self._number(index)} of {self.muscle} is put there."

    def _number(self, index: int) -> int:
        return self.table.points_of(self.muscle)[index].number

    def length(self, muscle: str | None = None) -> float:
        """Length of a muscle, the chosen one if None, at the pose of the design, in [m]."""
        name = self.muscle if muscle is None else muscle
        points = [point.position for point in self.table.points_of(name)]
        return sum(map(math.dist, points, points[1:]))

    # Mirror and CSV

    def mirror(self, plane: Plane, every: bool, replace_existing: bool) -> list[Finding]:
        """The chosen muscle, or all of its side, on the other side as well."""
        muscles = [self.muscle] if self.muscle else []
        if every:
            side = _side(self.muscle)
            muscles = [row.name for row in self.table.rows if _side(row.name) == side]
        findings: list[Finding] = []
        made = []
        for muscle in muscles:
            table, found = mirror_muscle(self.table, muscle, plane, self.links, replace_existing)
            findings += found
            before = self.table.points_of
            made += [r.name for r in table.rows if table.points_of(r.name) != before(r.name)]
            self.table = table
        texts = [finding.message for finding in findings]
        texts.append(f"Mirrored: {', '.join(made)}." if made else "Nothing was mirrored.")
        self.message = "\n".join(texts)
        return findings


def _side(name: str) -> str:
    """`left` or `right`, by what changes in the name of the other side."""
    other = other_side(name)
    if other is None:
        return ""
    return "left" if other_is_right(name, other) else "right"


def other_is_right(name: str, other: str) -> bool:
    """Whether the name is of the left side."""
    for a, b in zip(name.lower(), other.lower(), strict=False):
        if a != b:
            return a == "l"
    return False
