"""The dialog of Define muscles."""

from __future__ import annotations

from typing import Literal

from ...muscles.table import NAMED_COLORS
from ...robot.model.laws import MUSCLE_LAWS
from ..dialogs import Dialog, Input

NEW_MUSCLE = "+ New muscle"
OF_PART = "As the picked part"
TASK, MARKER = "Task point", "Marker"
PLANES = {
    "YZ plane (x changes sign)": (1.0, 0.0, 0.0),
    "XZ plane (y changes sign)": (0.0, 1.0, 0.0),
    "XY plane (z changes sign)": (0.0, 0.0, 1.0),
}
"""Planes through the design's origin, by their normals."""
PICKED_PLANE = "A picked plane"
SIDES: dict[str, Literal[-1, 0, 1]] = {"Shorter path": 0, "Turning +": 1, "Turning -": -1}
INSIDE = "Inside"
"""Beside those: led through the surface."""
MODELS = tuple(MUSCLE_LAWS)
"""Those that are simulated; others come from a table."""
NO_SURFACE = "(none yet)"
OTHER_COLOR = "Another one"

_POINTS = (
    "Vertices",
    "CircularEdges",
    "SketchPoints",
    "ConstructionPoints",
    "SphericalFaces",
    "ToroidalFaces",
)

_TABLE_BUTTONS = (
    Input("up", "button", "Up", "Moves the selected point towards the muscle's begin."),
    Input("down", "button", "Down", "Moves the selected point towards the muscle's end."),
    Input(
        "insert",
        "button",
        "Insert here",
        "The next points that you pick come before the selected one; again: at the end.",
    ),
    Input("duplicate", "button", "Duplicate", "A second point in the same place."),
    Input("delete", "button", "Delete", "Takes the selected point out of the muscle."),
)

_PROPERTIES = Input(
    "properties",
    "group",
    "Properties",
    children=(
        Input("muscle_name", "string", "Name", "How the muscle is called in every file."),
        Input(
            "palette",
            "dropdown",
            "Colour",
            "What it is drawn in, and has in the files.",
            options=(*NAMED_COLORS, OTHER_COLOR),
        ),
        Input("color", "string", "As #rrggbb", "Any other colour."),
        Input(
            "f_min",
            "number",
            "Smallest force [N]",
            "A cable must stay taut: a controller never commands less.",
            value=10.0,
        ),
        Input(
            "f_max",
            "number",
            "Largest force [N]",
            "What the motor can pull: a controller never commands more.",
            value=80.0,
        ),
        Input(
            "model",
            "dropdown",
            "Model",
            "What its tension follows from: 'ideal' is the commanded force, the others compute it "
            "from their command, the muscle's length and its speed.",
            options=MODELS,
            value="ideal",
        ),
        Input(
            "parameters",
            "table",
            "Parameters",
            "The model's numbers; where one is empty, the default behind its unit holds.",
            columns=("Parameter", "Value", "Unit, default, meaning"),
            widths=(4, 2, 5),
            rows=6,
        ),
        Input("delete_muscle", "button", "Delete muscle", "With all of its points."),
    ),
)

_MUSCLES = Input(
    "tab_muscles",
    "tab",
    "Muscles",
    children=(
        Input("muscle", "dropdown", "Muscle", "The muscle that picked points are added to."),
        Input(
            "pick",
            "selection",
            "Points",
            "Click the places that the muscle passes through, one after the other, in order: "
            "vertices, circles (their centre), sketch points, construction points, spheres and "
            "tori (their centre).",
            filters=_POINTS,
            prompt="Pick the next point of the muscle",
        ),
        Input(
            "link",
            "dropdown",
            "Link",
            "The link that picked points are fixed to.",
            options=(OF_PART,),
            value=OF_PART,
        ),
        Input(
            "points",
            "table",
            "Points",
            "The muscle's points, in order, at the design's pose. Other coordinates that you type "
            "put a point there.",
            columns=("No.", "Link", "x, y, z [mm]"),
            widths=(1, 3, 4),
            rows=8,
            children=_TABLE_BUTTONS,
        ),
        Input("length", "text", "Length", "At the design's pose."),
        _PROPERTIES,
    ),
)

_WRAPS = Input(
    "tab_wraps",
    "tab",
    "Wrap surfaces",
    children=(
        Input(
            "wrap_pick",
            "selection",
            "Faces",
            "Click cylinders and spheres that muscles wrap over.",
            filters=("CylindricalFaces", "SphericalFaces"),
            prompt="Pick a cylinder or sphere",
        ),
        Input("wrap", "dropdown", "Surface", "The surface shown below.", options=(NO_SURFACE,)),
        Input("wrap_name", "string", "Name", "How the surface is called in the files."),
        Input("wrap_link", "dropdown", "Link", "The link that the surface is fixed to."),
        Input(
            "wrap_uses",
            "table",
            "Muscles",
            "The muscles that wrap over this surface, and after which of their points.",
            columns=("Muscle", "After point", "Side", "Turns"),
            widths=(3, 2, 3, 2),
            rows=6,
            children=(
                Input("use_add", "button", "Add", "The muscle of the first tab wraps over it."),
                Input("use_delete", "button", "Delete", "The selected muscle does not."),
            ),
        ),
        Input("wrap_delete", "button", "Delete surface", "The face itself stays as it is."),
    ),
)

_OTHERS = Input(
    "tab_others",
    "tab",
    "Task points, markers",
    children=(
        Input(
            "other_role",
            "dropdown",
            "Pick",
            "Task points are controlled or reported; markers are what a camera sees.",
            options=(TASK, MARKER),
            value=TASK,
        ),
        Input(
            "other_pick",
            "selection",
            "Points",
            "Click the places; the name can be changed in the table.",
            filters=_POINTS,
            prompt="Pick a task point or marker",
        ),
        Input(
            "others",
            "table",
            "Points",
            "All task points and markers.",
            columns=("What", "Name", "Link"),
            widths=(2, 3, 3),
            rows=8,
            children=(Input("other_delete", "button", "Delete", "The selected one."),),
        ),
    ),
)

_TOOLS = Input(
    "tab_tools",
    "tab",
    "Mirror",
    children=(
        Input(
            "mirror_group",
            "group",
            "Mirror left to right",
            children=(
                Input(
                    "plane",
                    "dropdown",
                    "Plane",
                    "Through the design's origin, or a plane that you pick.",
                    options=(*PLANES, PICKED_PLANE),
                    value=next(iter(PLANES)),
                ),
                Input(
                    "plane_pick",
                    "selection",
                    "Picked plane",
                    "A flat face or a construction plane.",
                    filters=("PlanarFaces", "ConstructionPlanes"),
                    prompt="Pick the plane to mirror at",
                ),
                Input("mirror_all", "check", "All muscles of this side", "Not only this muscle."),
                Input(
                    "mirror_replace",
                    "check",
                    "Replace",
                    "Replaces the muscles of the other side that are there already.",
                ),
                Input(
                    "mirror",
                    "button",
                    "Mirror",
                    "A link or muscle whose name begins or ends with l, left, r or right has its "
                    "image on the other side: arm_l and arm_r, LeftArm and RightArm.",
                ),
            ),
        ),
    ),
)

_ALL = Input(
    "tab_all",
    "tab",
    "All",
    children=(
        Input(
            "all",
            "table",
            "Muscles",
            "All muscles, in the order of their forces.",
            columns=("Name", "Min. [N]", "Max. [N]", "Model", "Points, length"),
            widths=(4, 2, 2, 4, 4),
            rows=16,
            children=(
                Input(
                    "paste",
                    "button",
                    "Paste",
                    "Takes the cells that were copied in a spreadsheet, points included; muscles, "
                    "task points and markers of the same names are replaced.",
                ),
                Input("copy", "button", "Copy", "All points, to be put into a spreadsheet."),
                Input("csv_import", "button", "Import ...", "As Paste, from a CSV file."),
                Input("csv_export", "button", "Export ...", "Writes all points into a CSV file."),
            ),
        ),
    ),
)

DIALOG = Dialog(
    id="cardsflowDefineMuscles",
    folder="define_muscles",
    name="Define muscles",
    tooltip="Muscles by clicking the points that they pass through.",
    description="Each point belongs to the link of the part that you clicked. Muscles, task "
    "points, markers and wrap surfaces are kept in the design. Nothing of yours is changed; one "
    "undo takes it all back.",
    edits=True,
    inputs=(
        _MUSCLES,
        _ALL,
        _WRAPS,
        _OTHERS,
        _TOOLS,
        Input("status", "text", "Status", "What happened last, and why OK is grey.", rows=4),
    ),
)
