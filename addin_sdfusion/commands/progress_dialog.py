"""Progress dialog, with a button that cancels if that can be."""

from __future__ import annotations

from typing import Any

import adsk

from ..progress import Cancelled
from .guard import application


class ProgressDialog:
    """A dialog that is a `Progress`; on the screen from its first call on."""

    def __init__(self, title: str, *, cancellable: bool = True) -> None:
        self._title = title
        self._cancellable = cancellable
        self._dialog: Any = None

    def __call__(self, done: int, whole: int, what: str) -> None:
        """Show how far it is.

        Raises:
            Cancelled: The user has pressed Cancel.
        """
        whole = max(whole, 1)  # Fusion rejects a dialog without a range
        if self._dialog is None:
            self._dialog = application().userInterface.createProgressDialog()
            self._dialog.isCancelButtonShown = self._cancellable
            self._dialog.show(self._title, what, 0, whole, 0)
        self._dialog.maximumValue = whole
        self._dialog.progressValue = min(max(done, 0), whole)
        self._dialog.message = what or self._title
        adsk.doEvents()
        if self._dialog.wasCancelled:
            raise Cancelled

    def hide(self) -> None:
        """Takes it away."""
        if self._dialog is not None:
            self._dialog.hide()
