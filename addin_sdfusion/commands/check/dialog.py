"""The dialog of Check."""

from __future__ import annotations

from ..dialogs import Dialog, Example, Input

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

EXAMPLE = Example(
    values={
        "summary": "1 error, 2 warnings. Errors must be repaired before the export.",
        "detail": "muscle biceps_l: point 2 is on link forearm_L, which does not exist; did you "
        "mean 'forearm_l'? Choose the link in Define muscles.",
    },
    cells={
        "findings": (
            ("error", "muscle biceps_l", "point 2 is on link forearm_L, which does not exist"),
            ("warning", "joint wrist_l", "has limits 0 to 0 and cannot move"),
            ("warning", "body Cover", "belongs to no rigid group and is left out"),
        )
    },
    selected={"findings": 0},
    icons={"findings": {name: f"check/resources/{icon}" for name, icon in ICONS.items()}},
)
