"""Editor of a muscle table and its current selection, independent of Fusion.

An invalid edit raises an `InputError` and changes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from ...muscles.mirror import FindFace, Plane, mirror_muscle, other_side
from ...muscles.point_names import natural_key
from ...muscles.table import MuscleTable, PointRow, WrapRow, change_uses, free_name
from ...robot.errors import InputError
from ...robot.model.muscle import CableKind
from ...robot.model.muscle_laws import law_of
from ...robot.model.pose import Vector3
from ...robot.model.robot import POSITIONS, WORLD
from ...snapshot import MuscleSnapshot, Role, SurfaceSnapshot, WrapUse

HANDLE = "pick:"
"""Prefix of the handles of picked entities that are not construction points."""


@dataclass(frozen=True, slots=True)
class Pick:
    """Point or face that the user clicked.

    Attributes:
        position: Position in the root frame, in [m].
        occurrence: Path of the clicked occurrence.
        entity: Identifier of the clicked construction point, or a handle of another entity.
        part: Name for messages.
        problem: Reason why it cannot be used, or an empty string.
        face: The cylinder or sphere, if a surface was picked.
    """

    position: Vector3
    occurrence: str
    entity: str
    part: str
    problem: str = ""
    face: SurfaceSnapshot | None = None


class MuscleEditor:
    """Editor of a muscle table.

    Attributes:
        before: Table stored in the design.
        table: Edited table, which OK writes to the design.
        link_of: Link of each occurrence, by path.
        links: Names of all links.
        muscle: Name of the chosen muscle, to which picked points are added; empty if none exists.
        insert_at: Index of the next picked point; None to append it.
        link: Link of picked points; empty for the link of the picked part.
        wrap: Name of the chosen wrap surface.
        message: Message on the last action.
    """

    def __init__(self, table: MuscleTable, link_of: Mapping[str, str], note: str = "") -> None:
        self.before = table
        self.table = table.renumber()
        self.link_of = link_of
        self.links = sorted(set(link_of.values()) - {WORLD}, key=natural_key)
        self.muscle = table.rows[0].name if table.rows else ""
        self.insert_at: int | None = None
        self.link = ""
        self.wrap = table.wraps[0].name if table.wraps else ""
        self.message = note

    # Picks

    def pick_point(self, pick: Pick) -> None:
        """Add a via point to the chosen muscle, which is created if necessary."""
        point = self._row("via", pick, muscle=self.muscle or self.table.new_muscle_name())
        self.table = self.table.insert_point(point, self.insert_at)
        self.muscle = point.muscle
        index = -1
        if self.insert_at is not None:
            index, self.insert_at = self.insert_at, self.insert_at + 1
        self.message = f"{self._point(index)} is on link {point.link}."

    def pick_other(self, pick: Pick, role: Literal["task", "marker"]) -> None:
        """Add a task point or marker with a unique name."""
        point = self._row(role, pick, axes=POSITIONS if role == "task" else ())
        tasks, markers = self.table.tasks, self.table.markers
        alike = tasks if role == "task" else markers
        names = (f"{point.link}_{n}" if n else point.link for n in range(len(alike) + 1))
        point = replace(point, name=free_name(list(names), alike))
        others = (*tasks, point, *markers) if role == "task" else (*tasks, *markers, point)
        self.table = replace(self.table, others=others)
        kind = "Task point" if role == "task" else "Marker"
        self.message = f"{kind} {point.name} is on link {point.link}."

    def pick_surface(self, pick: Pick) -> None:
        """Add a wrap surface, or choose an existing one."""
        wraps = self.table.wraps
        known = next((wrap for wrap in wraps if wrap.face.entity == pick.entity), None)
        if known is not None:
            self.wrap = known.name
            raise InputError(f"This face is already wrap surface {self.wrap}.")
        link, face = self._link(pick), pick.face
        if face is None:
            return
        names = [f"{link}_{face.shape}{n or ''}" for n in range(len(wraps) + 1)]
        self.wrap = free_name(names, wraps)
        row = WrapRow(self.wrap, link, occurrence=pick.occurrence, face=face)
        self.table = replace(self.table, wraps=(*wraps, row))
        size = f"a {face.shape} of radius {1000 * face.radius:.4g} mm"
        self.message = f"Wrap surface {self.wrap} is {size} on link {link}."

    def _row(self, role: Role, pick: Pick, **more: Any) -> PointRow:
        """Return the row of a picked point; a construction point can have only one use."""
        taken = {row.entity for row in (*self.table.points, *self.table.others)}
        entity = "" if pick.entity in taken and not pick.entity.startswith(HANDLE) else pick.entity
        link, path = self._link(pick), pick.occurrence
        return PointRow(role, link, occurrence=path, position=pick.position, entity=entity, **more)

    def _link(self, pick: Pick) -> str:
        """Return the link of a picked point or face."""
        if pick.problem:
            raise InputError(pick.problem)
        link = self.link or self.link_of.get(pick.occurrence, "")
        if not link:
            raise InputError(
                f"{pick.part} does not belong to a link: add it to a rigid group EXPORT_<link>, or "
                "choose a link in the drop-down and pick again."
            )
        return link

    # Wrap surfaces, task points, markers

    def wrap_row(self) -> WrapRow | None:
        """Return the chosen wrap surface."""
        return next((wrap for wrap in self.table.wraps if wrap.name == self.wrap), None)

    def change_wrap(self, **changes: Any) -> None:
        """Change properties of the chosen wrap surface."""
        self.table = self.table.change_wrap(self.wrap, lambda wrap: replace(wrap, **changes))

    def rename_wrap(self, name: str) -> None:
        """Rename the chosen wrap surface; reject an empty or existing name."""
        name = name.strip()
        if name == self.wrap:
            return
        if not name or any(wrap.name == name for wrap in self.table.wraps):
            raise InputError(f"Wrap surface {name!r} exists already; choose another name.")
        self.change_wrap(name=name)
        self.wrap = name

    def delete_wrap(self) -> None:
        """Delete the chosen wrap surface."""
        self.table = self.table.change_wrap(self.wrap, lambda wrap: None)
        self.wrap = self.table.wraps[0].name if self.table.wraps else ""

    def add_use(self) -> None:
        """Add the chosen muscle to the wrap surface, after its first point."""
        points, wrap = self.table.points_of(self.muscle), self.wrap_row()
        if wrap is None or len(points) < 2:
            text = "Pick a face, and choose a muscle with two points on the first tab."
            raise InputError(text)
        self.change_wrap(muscles=(*wrap.muscles, WrapUse(self.muscle, points[0].number)))

    def change_use(self, index: int, **changes: Any) -> None:
        """Change properties of the wrap of one muscle."""
        self._edit_use(index, lambda use: replace(use, **changes))

    def delete_use(self, index: int) -> None:
        """Remove a muscle from the wrap surface."""
        self._edit_use(index, lambda use: None)

    def _edit_use(self, index: int, edit: Any) -> None:
        self.table = self.table.change_wrap(
            self.wrap,
            lambda wrap: change_uses(wrap, lambda i, use: edit(use) if i == index else use),
        )

    def rename_other(self, index: int, name: str) -> None:
        """Rename a task point or marker."""
        self._edit_other(index, replace(self.table.others[index], name=name.strip()))

    def move_other(self, index: int, link: str) -> None:
        """Change the link of a task point or marker."""
        point = self.table.others[index]
        if point.link != link:
            self._edit_other(index, point.on_link(link))

    def delete_other(self, index: int) -> None:
        """Delete a task point or marker."""
        if not 0 <= index < len(self.table.others):
            raise InputError("Select a task point or marker in the table first.")
        self._edit_other(index)

    def _edit_other(self, index: int, *new: PointRow) -> None:
        others = self.table.others
        self.table = replace(self.table, others=(*others[:index], *new, *others[index + 1 :]))

    # The chosen muscle

    def choose(self, muscle: str) -> None:
        """Choose the muscle to which picked points are added; a new muscle if empty."""
        if not muscle:
            muscle = self.table.new_muscle_name()
            self.table = self.table.with_muscle(MuscleSnapshot(muscle, self.table.next_color()))
            self.message = f"{muscle} is new: pick its points, in order."
        self.muscle = muscle
        self.insert_at = None

    def rename(self, name: str, muscle: str | None = None) -> None:
        """Rename a muscle (default: the chosen one); reject an empty or existing name."""
        name, old = name.strip(), self.muscle if muscle is None else muscle
        if not old or name == old:
            return
        if not name or not name.isprintable():
            raise InputError("The name of a muscle must contain visible characters.")
        if self.table.row(name) is not None:
            raise InputError(f"Muscle {name} exists already; choose another name.")
        self.table = self.table.rename_muscle(old, name)
        self.muscle = name if old == self.muscle else self.muscle

    def delete(self) -> None:
        """Delete the chosen muscle with its points."""
        if self.muscle:
            self.table = self.table.delete_muscle(self.muscle)
            self.message = f"{self.muscle} is deleted."
            self.muscle = self.table.rows[0].name if self.table.rows else ""
            self.insert_at = None

    def change(self, muscle: str | None = None, **changes: Any) -> None:
        """Change properties of a muscle (default: the chosen one)."""
        row = self.table.row(self.muscle if muscle is None else muscle)
        if row is not None:
            self.table = self.table.with_muscle(replace(row, **changes))

    def change_model(self, muscle: str, model: CableKind) -> None:
        """Change the muscle law of a muscle and keep the parameters that both laws have."""
        row = self.table.row(muscle)
        if row is not None:
            known = parameter_names(replace(row, model=model, parameters={}))
            kept = {name: number for name, number in row.parameters.items() if name in known}
            self.change(muscle, model=model, parameters=kept)

    def edit_point(self, what: str, index: int) -> int:
        """Handle a button below the table of points.

        Args:
            what: `up`, `down`, `insert`, `duplicate` or `delete`.
            index: Index of the selected point, or -1.

        Returns:
            Index of the newly selected point, or -1.
        """
        count = len(self.table.points_of(self.muscle))
        if what == "insert" and self.insert_at is not None:
            self.insert_at = None
            self.message = "The next points are appended."
            return index
        if not 0 <= index < count:
            raise InputError("Select a point in the table first.")
        if what == "insert":
            self.insert_at = index
            number = self.table.points_of(self.muscle)[index].number
            self.message = f"The next points are inserted before point {number}."
            return index
        self.insert_at = None
        if what == "duplicate":
            self.table.points_of(self.muscle)[index].require_found()
            self.table = self.table.duplicate_point(self.muscle, index)
            return index + 1
        if what == "delete":
            self.table = self.table.delete_point(self.muscle, index)
            return min(index, count - 2)
        by = -1 if what == "up" else 1
        self.table = self.table.move_point(self.muscle, index, by)
        return min(max(index + by, 0), count - 1)

    def point_link(self, index: int, link: str) -> None:
        """Change the link of a point of the chosen muscle."""
        if self.table.points_of(self.muscle)[index].link != link:
            self.table = self.table.change_point(self.muscle, index, lambda p: p.on_link(link))
            self.message = f"{self._point(index)} is on link {link}."

    def point_position(self, index: int, position: Vector3) -> None:
        """Move a point of the chosen muscle to a position, in [m]."""
        self.table.points_of(self.muscle)[index].require_found()
        self.table = self.table.change_point(
            self.muscle, index, lambda p: replace(p, position=position, entity="", made=False)
        )
        self.message = f"{self._point(index)} is moved."

    def _point(self, index: int) -> str:
        return f"Point {self.table.points_of(self.muscle)[index].number} of {self.muscle}"

    def replace_link(self, old: str, new: str) -> None:
        """Move all points and wrap surfaces of one link to another link.

        Args:
            old: The link to replace, which may not exist any more.
            new: The other link; empty for the link of each part.
        """
        if not old or old == new:
            raise InputError("Choose the link to replace and another link.")
        self.table = self.table.replace_link(old, new, self.link_of)
        self.message = f"Link {old} is replaced by {new or 'the link of each part'}."

    # Mirror and CSV

    def mirror(
        self, plane: Plane, every: bool, replace_existing: bool, find_face: FindFace
    ) -> None:
        """Mirror the chosen muscle, or all muscles of its side, to the other side."""
        muscles = [self.muscle] if self.muscle else []
        if every:
            side = _side(self.muscle)
            muscles = [row.name for row in self.table.rows if _side(row.name) == side]
        texts: list[str] = []
        made: list[str] = []
        for muscle in muscles:
            table, found = mirror_muscle(
                self.table, muscle, plane, self.links, replace_existing, find_face
            )
            texts += [finding.message for finding in found]
            before = self.table.points_of
            made += [r.name for r in table.rows if table.points_of(r.name) != before(r.name)]
            self.table = table
        texts.append(f"Mirrored: {', '.join(made)}." if made else "Nothing was mirrored.")
        self.message = "\n".join(texts)

    def take(self, table: MuscleTable) -> None:
        """Merge a table read from a file, which replaces equal names."""
        self.table = self.table.merge(table).renumber()
        if table.rows:
            self.choose(table.rows[0].name)


def parameter_names(row: MuscleSnapshot) -> list[str]:
    """Return the parameters of the muscle law, then the stored parameters unknown to it."""
    names = [p.name for p in law_of(row.cable_model).parameters]
    return list(dict.fromkeys([*names, *row.parameters]))


def _side(name: str) -> str:
    """Return `left` or `right`, depending on the side in a name, or an empty string."""
    other = other_side(name)
    if other is None:
        return ""
    changed = next(a for a, b in zip(name.lower(), other.lower(), strict=False) if a != b)
    return "left" if changed == "l" else "right"
