"""The dialog of Check."""

from __future__ import annotations

from ..dialogs import Dialog, Example, Input

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
            "Errors keep the robot from being exported; warnings do not.",
            columns=("", "Object", "What is wrong, and what to do"),
            widths=(2, 3, 8),
            rows=10,
            children=(
                Input(
                    "show",
                    "button",
                    "Show in the design",
                    "Selects what the selected line is about, and looks at it.",
                ),
                Input("again", "button", "Check again", "After the design has changed."),
            ),
        ),
        Input("detail", "text", "Selected", "The whole text of the selected line.", rows=5),
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
)
