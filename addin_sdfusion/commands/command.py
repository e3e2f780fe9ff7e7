"""Command with a button in the Add-Ins panel, and its open dialog."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import adsk.core
import adsk.fusion

from ..fusion.notes import optional
from ..robot.errors import InputError
from .dialogs import Dialog
from .guard import application, guard_handler, message, report
from .inputs import Inputs

PANEL = "SolidScriptsAddinsPanel"

_PENDING = (
    "Parts were moved but their position is not captured, so Fusion would move them back. Press "
    "Capture Position or Revert Position in the toolbar, then start the command again."
)
_HANDLERS = {
    "commandCreated": "CommandCreatedEventHandler",
    "execute": "CommandEventHandler",
    "executePreview": "CommandEventHandler",
    "destroy": "CommandEventHandler",
    "inputChanged": "InputChangedEventHandler",
    "validateInputs": "ValidateInputsEventHandler",
}


class Window:
    """Base class of an open dialog; each command has a subclass."""

    def __init__(self, inputs: Inputs, design: Any) -> None:
        """Read the design; the inputs do not exist before `on_open`.

        Raises:
            Cancelled: The user cancelled the reading; the dialog does not open.
        """
        self.inputs = inputs
        self.design = design

    def on_open(self) -> None:
        """Handle that the dialog was opened."""

    def on_change(self, changed: Any) -> None:
        """Handle a changed input; this must not edit the design."""

    def valid(self) -> bool:
        """Return whether the OK button is enabled."""
        return True

    def preview(self) -> None:
        """Preview the result of OK; Fusion reverts all changes."""

    def execute(self) -> None:
        """Edit the design in one undo step."""


class Command:
    """Command of the add-in."""

    def __init__(self, dialog: Dialog, open_window: Callable[[Inputs, Any], Window]) -> None:
        """Create a command without a button."""
        self.dialog = dialog
        self._open_window = open_window
        self._handlers: list[Any] = []  # Fusion does not hold references to handlers
        self._kept_by_window: list[Any] = []
        self._window: Window | None = None

    def start(self) -> None:
        """Create the button and replace an existing one."""
        self.stop()
        ui = application().userInterface
        folder = Path(__file__).parent / self.dialog.folder / "resources"
        tooltip = f"{self.dialog.tooltip}\n\n{self.dialog.description}"
        definition = ui.commandDefinitions.addButtonDefinition(
            self.dialog.id, self.dialog.name, tooltip, str(folder)
        )
        clip = folder / "toolclip.png"
        if clip.is_file():
            definition.toolClipFilename = str(clip)
        opened = guard_handler(self._open, self.dialog.name)
        self._connect(definition, "commandCreated", opened, self._handlers)
        panel = ui.allToolbarPanels.itemById(PANEL)
        if panel is not None:
            control = panel.controls.addCommand(definition)
            control.isPromotedByDefault = True
            control.isPromoted = True

    def stop(self) -> None:
        """Remove the button and close the dialog; may be called at any time."""
        ui = application().userInterface
        if self._window is not None and ui.activeCommand == self.dialog.id:
            ui.terminateActiveCommand()
        panel = ui.allToolbarPanels.itemById(PANEL)
        control = panel.controls.itemById(self.dialog.id) if panel is not None else None
        if control is not None:
            control.deleteMe()
        definition = ui.commandDefinitions.itemById(self.dialog.id)
        if definition is not None:
            definition.deleteMe()
        self._window = None
        self._handlers.clear()
        self._kept_by_window.clear()

    def _connect(
        self, sender: Any, event: str, work: Callable[[Any], None], handlers: list[Any]
    ) -> None:
        base = getattr(adsk.core, _HANDLERS[event])
        handler = type(_HANDLERS[event], (base,), {"notify": lambda _, args: work(args)})()
        getattr(sender, event).add(handler)
        handlers.append(handler)

    def _open(self, args: Any) -> None:
        self._window = None
        self._kept_by_window = []
        design = active_design()
        if design is None:
            text = "Open a design first: CARDSFlow works in the Design workspace."
            message(text, self.dialog.name)
            return
        if self.dialog.edits and optional(lambda: bool(design.snapshots.hasPendingSnapshot)):
            message(_PENDING, self.dialog.name)
            return
        command = args.command
        inputs = Inputs(command, self.dialog)
        window = self._open_window(inputs, design)  # may be cancelled while it reads the design
        if not command.isValid:  # another command was started while the progress was shown
            return
        inputs.create()
        command.helpFile = str(Path(__file__).parent / "help.html")
        command.isRepeatable = True
        command.isExecutedWhenPreEmpted = False  # another command must not confirm the dialog
        command.isOKButtonVisible = bool(self.dialog.ok)
        if self.dialog.ok:
            command.okButtonText = self.dialog.ok
        command.cancelButtonText = self.dialog.cancel
        command.setDialogInitialSize(*self.dialog.size)
        name = self.dialog.name
        for event, work in (
            ("inputChanged", guard_handler(self._on_change, name)),
            ("validateInputs", self._on_validate),
            ("executePreview", guard_handler(self._on_preview, f"{name} (preview)", quiet=True)),
            ("execute", self._on_execute),
            ("destroy", guard_handler(self._on_destroy, name)),
        ):
            self._connect(command, event, work, self._kept_by_window)
        window.on_open()
        self._window = window  # events before this line are ignored and OK is disabled

    def _on_change(self, args: Any) -> None:
        window = self._window
        if (
            window is None
            or not self._same_design()
            or window.inputs.is_programmatic_change(args.input)
        ):
            return
        window.inputs.written = str(args.input.id)
        try:
            window.on_change(args.input)
        finally:
            window.inputs.written = ""

    def _on_validate(self, args: Any) -> None:
        valid = False

        def ask(_: Any) -> None:
            nonlocal valid
            valid = self._window is not None and self._same_design() and self._window.valid()

        guard_handler(ask, f"{self.dialog.name} (OK)", quiet=True)(args)
        args.areInputsValid = valid

    def _on_preview(self, _: Any) -> None:
        if self._window is not None and self._same_design():
            self._window.preview()

    def _on_execute(self, args: Any) -> None:
        """Edit the design; after a failure Fusion reverts the whole undo step."""
        try:
            if self._window is None or not self._same_design():
                raise InputError("Another document is active; start the command again.")
            self._window.execute()
        except Exception as error:
            args.executeFailed = True
            args.executeFailedMessage = report(error, self.dialog.name)

    def _on_destroy(self, _: Any) -> None:
        self._window = None

    def _same_design(self) -> bool:
        """Return whether the design is still active."""
        design = self._window.design if self._window is not None else None
        return design is not None and bool(design.isValid) and bool(active_design() == design)


def active_design() -> Any:
    """Return the active design, or None."""
    return adsk.fusion.Design.cast(application().activeProduct)
