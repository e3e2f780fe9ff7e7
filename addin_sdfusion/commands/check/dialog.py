"""Dialog of Check."""

from __future__ import annotations

from ..dialogs import Dialog, Input

SHOWABLE = (
    *("Occurrences", "SolidBodies", "SurfaceBodies", "MeshBodies"),
    *("Joints", "ConstructionPoints", "Faces"),
)
ICONS = {"error": "severity/error", "warning": "severity/warning"}
"""Folders of the icons on the buttons of the rows."""

DIALOG = Dialog(
    id="cardsflowCheck",
    folder="check",
    name="Check",
    tooltip="Lists all problems of the design.",
    description="Finds all problems that would prevent the export or the simulation of the robot, "
    "and how to fix them. The design is not changed.",
    inputs=(
        Input("summary", "text", "Result", "Number of errors and warnings.", rows=2),
        Input(
            "findings",
            "table",
            "Findings",
            "Errors prevent the export of the robot; warnings do not. The button of a row shows "
            "the object in the design.",
            columns=("", "Object", "Problem and solution"),
            widths=(1, 3, 9),
            rows=10,
            children=(
                Input("again", "button", "Check again", "Reads the design again after a change."),
                Input("copy", "button", "Copy report", "Copies all rows as text."),
                Input(
                    "save",
                    "button",
                    "Save snapshot",
                    "Writes all data that the add-in reads from the design to a file, which can be "
                    "attached to a problem report.",
                ),
            ),
        ),
        Input(
            "shown",
            "selection",
            "Shown",
            "The object of the selected row.",
            filters=SHOWABLE,
            prompt="Press the button of a row",
        ),
        Input("detail", "text", "Shown row", "Complete text of the selected row.", rows=5),
    ),
    ok="",
    cancel="Close",
    size=(640, 520),
)
