"""The dialog of Check."""

from __future__ import annotations

from ..dialogs import Dialog, Input

SHOWABLE = (
    *("Occurrences", "SolidBodies", "SurfaceBodies", "MeshBodies"),
    *("Joints", "ConstructionPoints", "Faces"),
)
ICONS = {"error": "severity/error", "warning": "severity/warning"}
"""Folders of the icons on the buttons of the lines."""

DIALOG = Dialog(
    id="cardsflowCheck",
    folder="check",
    name="Check",
    tooltip="Everything that is wrong with the design, at once.",
    description="Finds what would keep the robot from being exported or simulated, and says what "
    "to click. Nothing is changed.",
    inputs=(
        Input("summary", "text", "Result", "How many errors and warnings there are.", rows=2),
        Input(
            "findings",
            "table",
            "Findings",
            "Errors keep the robot from being exported; warnings do not. The button of a line "
            "shows in the design what it is about.",
            columns=("", "Object", "What is wrong, and what to do"),
            widths=(1, 3, 9),
            rows=10,
            children=(
                Input("again", "button", "Check again", "After the design has changed."),
                Input("copy", "button", "Copy report", "All lines as text, to be sent to someone."),
                Input(
                    "save",
                    "button",
                    "Save snapshot",
                    "A file with all that the add-in reads of the design, to attach to a report.",
                ),
            ),
        ),
        Input(
            "shown",
            "selection",
            "Shown",
            "What the line is about whose button was pressed.",
            filters=SHOWABLE,
            prompt="Press the button of a line",
        ),
        Input("detail", "text", "Shown line", "Its whole text.", rows=5),
    ),
    ok="",
    cancel="Close",
    size=(640, 520),
)
