"""Progress dialog with a cancel button."""

from __future__ import annotations

from typing import Any

import adsk

from ..progress import Cancelled
from .guard import application


class ProgressDialog:
    """Dialog that implements `Progress`; it opens at the first call."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._dialog: Any = None

    def __call__(self, done: int, total: int, step: str) -> None:
        """Show the progress.

        Raises:
            Cancelled: The user pressed Cancel.
        """
        total = max(total, 1)  # Fusion rejects a dialog without a range
        if self._dialog is None:
            self._dialog = application().userInterface.createProgressDialog()
            self._dialog.isCancelButtonShown = True
            self._dialog.show(self._title, step, 0, total, 0)
        self._dialog.maximumValue = total
        self._dialog.progressValue = min(max(done, 0), total)
        self._dialog.message = step or self._title
        adsk.doEvents()
        if self._dialog.wasCancelled:
            raise Cancelled

    def hide(self) -> None:
        """Close the dialog."""
        if self._dialog is not None:
            self._dialog.hide()
