"""What the user has done in the dialog so far: the pending table, apart from Fusion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from ...muscles.edits import (
    delete_muscle,
    delete_point,
    duplicate_point,
    insert_point,
    move_point,
    new_muscle_name,
    next_color,
    rename_muscle,
    set_link,
    with_muscle,
)
from ...muscles.mirror import Plane, mirror_muscle, other_side
from ...muscles.rows import MuscleRow, MuscleTable, ViaPointRow
from ...robot.finding import Finding
from .pending import Pending, Pick


class Session(Pending):
    """The pending table and the muscle that the user looks at.

    Attributes:
        muscle: Name of the muscle that picks go to; empty if there is none.
        insert_at: Where in the muscle the next pick goes; at the end if None.
    """

    def __init__(self, table: MuscleTable, link_of: Mapping[str, str], note: str = "") -> None:
        super().__init__(table, link_of, note)
        self.muscle = table.rows[0].name if table.rows else ""
        self.insert_at: int | None = None

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

    # The chosen muscle

    def choose(self, muscle: str) -> None:
        """Picks go to that muscle; to a new one if empty."""
        if not muscle:
            muscle = new_muscle_name(self.table)
            self.table = with_muscle(self.table, MuscleRow(muscle, next_color(self.table)))
            self.message = f"{muscle} is new: pick its points, in order."
        self.muscle = muscle
        self.insert_at = None

    def rename(self, name: str) -> None:
        """Another name for the chosen muscle; a name that is taken or empty is refused."""
        name = name.strip()
        if not self.muscle or name == self.muscle:
            return
        if not name or not name.isprintable():
            self.message = "A muscle needs a name of letters that can be seen."
        elif self.table.row(name) is not None:
            self.message = f"There is a muscle {name} already; choose another name."
        else:
            self.table = rename_muscle(self.table, self.muscle, name)
            self.muscle = name

    def delete(self) -> None:
        """The chosen muscle goes, with its points."""
        if self.muscle:
            self.table = delete_muscle(self.table, self.muscle)
            self.message = f"{self.muscle} is deleted."
            self.muscle = self.table.rows[0].name if self.table.rows else ""
            self.insert_at = None

    def change(self, edit: Callable[[MuscleRow], MuscleRow]) -> None:
        """Other properties of the chosen muscle."""
        row = self.table.row(self.muscle)
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

    def _number(self, index: int) -> int:
        return self.table.points_of(self.muscle)[index].number

    def length(self) -> float:
        """Length of the chosen muscle at the pose of the design, in [m]."""
        points = [point.position for point in self.table.points_of(self.muscle)]
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
