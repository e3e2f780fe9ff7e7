"""Undo and redo of edits while the dialog is open."""

from __future__ import annotations

from typing import NamedTuple

from ...muscles.table import MuscleTable
from ...robot.errors import InputError
from .editor import MuscleEditor


class State(NamedTuple):
    """Table of an editor, with the chosen muscle and wrap surface."""

    table: MuscleTable
    muscle: str
    wrap: str


class History:
    """Earlier and undone states of an editor."""

    def __init__(self, editor: MuscleEditor) -> None:
        self._editor = editor
        self._past: list[State] = []
        self._undone: list[State] = []
        self._typed = ""

    def state(self) -> State:
        """Return the current state."""
        editor = self._editor
        return State(editor.table, editor.muscle, editor.wrap)

    def record(self, before: State, typed: str = "") -> None:
        """Record an edit, if the table changed.

        Args:
            before: The state before the edit.
            typed: Id of the text or number field that was edited; characters typed in succession
                in one field are one step. Empty for other edits.
        """
        continued = bool(typed) and typed == self._typed and bool(self._past)
        self._typed = typed
        if self._editor.table != before.table:
            self._undone.clear()
            if not continued:
                self._past.append(before)

    def undo(self) -> None:
        """Restore the state before the last edit."""
        self._restore(self._past, self._undone, "undone")

    def redo(self) -> None:
        """Restore the state before the last undo."""
        self._restore(self._undone, self._past, "redone")

    def _restore(self, source: list[State], target: list[State], what: str) -> None:
        self._typed = ""
        if not source:
            raise InputError(f"Nothing can be {what} in this dialog.")
        target.append(self.state())
        editor = self._editor
        editor.table, editor.muscle, editor.wrap = source.pop()
        editor.insert_at = None
        editor.message = f"The last edit is {what}; {len(source)} more can be {what}."
