"""Muscle table of the open dialog, with its selection, message and undo.

The dialog, the preview, the writing and the list of problems read this object. The other modules
of this package contain its edits. An invalid edit raises an `InputError` and changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from ....muscles.point_names import natural_key
from ....muscles.rows import PointRow, WrapRow
from ....muscles.table import MuscleTable
from ....robot.errors import CardsflowError, InputError
from ....robot.model.robot import WORLD
from ....snapshot import MuscleSnapshot
from .problems import problems


class _State(NamedTuple):
    """The part of a model that undo restores."""

    table: MuscleTable
    muscle: str
    wrap: str


class MuscleModel:
    """Muscle table of the open dialog.

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
        self._past: list[_State] = []
        self._undone: list[_State] = []
        self._typed = ""

    # Chosen rows

    @property
    def row(self) -> MuscleSnapshot | None:
        """The chosen muscle."""
        return self.table.row(self.muscle)

    @property
    def points(self) -> tuple[PointRow, ...]:
        """The points of the chosen muscle."""
        return self.table.points_of(self.muscle)

    @property
    def wrap_row(self) -> WrapRow | None:
        """The chosen wrap surface."""
        return next((wrap for wrap in self.table.wraps if wrap.name == self.wrap), None)

    def problems(self) -> list[str]:
        """Return a sentence for every problem that prevents writing the table."""
        return problems(self.table, self.links)

    def hints(self) -> list[str]:
        """Return hints on incomplete muscles."""
        few = (row.name for row in self.table.rows if len(self.table.points_of(row.name)) < 2)
        return [f"{name} needs at least two points." for name in few]

    # Undo

    @contextmanager
    def step(self, typed: str = "") -> Iterator[None]:
        """Record the edits of the context as one step; an error becomes the message.

        Args:
            typed: Id of the text or number field that is edited; characters typed in succession in
                one field are one step. Empty for other edits.
        """
        before = self._state()
        with self.reporting():
            yield
        continued = bool(typed) and typed == self._typed and bool(self._past)
        self._typed = typed
        if self.table != before.table:
            self._undone.clear()
            if not continued:
                self._past.append(before)

    @contextmanager
    def reporting(self) -> Iterator[None]:
        """Show an error of the context as message."""
        try:
            yield
        except CardsflowError as error:
            self.message = str(error)

    def undo(self) -> None:
        """Restore the state before the last edit."""
        self._restore(self._past, self._undone, "undone")

    def redo(self) -> None:
        """Restore the state before the last undo."""
        self._restore(self._undone, self._past, "redone")

    def _restore(self, source: list[_State], target: list[_State], action: str) -> None:
        self._typed = ""
        if not source:
            raise InputError(f"Nothing can be {action} in this dialog.")
        target.append(self._state())
        self.table, self.muscle, self.wrap = source.pop()
        self.insert_at = None
        self.message = f"The last edit is {action}; {len(source)} more can be {action}."

    def _state(self) -> _State:
        return _State(self.table, self.muscle, self.wrap)
