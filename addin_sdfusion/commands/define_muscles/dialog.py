"""Dialog of Define muscles."""

from __future__ import annotations

from typing import Literal

from ...muscles.table import NAMED_COLORS
from ...robot.model.laws import MUSCLE_LAWS
from ..dialogs import Dialog, Input

NEW_MUSCLE = "+ New muscle"
OF_PART = "Link of the picked part"
NO_LINK = "(no points yet)"
TASK, MARKER = "Task point", "Marker"
PLANES = {
    "YZ plane (x changes sign)": (1.0, 0.0, 0.0),
    "XZ plane (y changes sign)": (0.0, 1.0, 0.0),
    "XY plane (z changes sign)": (0.0, 0.0, 1.0),
}
"""Planes through the origin of the design, with their normals."""
PICKED_PLANE = "A picked plane"
SIDES: dict[str, Literal[-1, 0, 1]] = {"Shorter path": 0, "Turning +": 1, "Turning -": -1}
INSIDE = "Inside"
"""Additional side: the muscle passes through the inside of the surface."""
MODELS = tuple(MUSCLE_LAWS)
"""Muscle laws that can be simulated; imported tables may contain others."""
NO_SURFACE = "(none yet)"
NO_JOINT = "(no moving joints)"
OTHER_COLOR = "Custom"

_POINTS = (
    "Vertices",
    "CircularEdges",
    "SketchPoints",
    "ConstructionPoints",
    "SphericalFaces",
    "ToroidalFaces",
)

_TABLE_BUTTONS = (
    Input("up", "button", "Up", "Moves the selected point towards the start of the muscle."),
    Input("down", "button", "Down", "Moves the selected point towards the end of the muscle."),
    Input(
        "insert",
        "button",
        "Insert here",
        "Inserts the next picked points before the selected one. Press again to append points.",
    ),
    Input("duplicate", "button", "Duplicate", "Adds a copy of the selected point."),
    Input("delete", "button", "Delete", "Removes the selected point from the muscle."),
)

_PROPERTIES = Input(
    "properties",
    "group",
    "Properties",
    children=(
        Input("muscle_name", "string", "Name", "Name of the muscle in all files."),
        Input(
            "palette",
            "dropdown",
            "Colour",
            "Colour of the muscle in drawings and files.",
            options=(*NAMED_COLORS, OTHER_COLOR),
        ),
        Input("color", "string", "As #rrggbb", "Custom colour."),
        Input(
            "f_min",
            "number",
            "Minimum force [N]",
            "Minimum force that a controller commands, which keeps the cable taut.",
            value=10.0,
        ),
        Input(
            "f_max",
            "number",
            "Maximum force [N]",
            "Maximum force that a controller commands: the limit of the motor.",
            value=80.0,
        ),
        Input(
            "model",
            "dropdown",
            "Muscle law",
            "Law that determines the tension: 'ideal' is the commanded force; the others compute "
            "the tension from the command and the length and speed of the muscle.",
            options=MODELS,
            value="ideal",
        ),
        Input(
            "parameters",
            "table",
            "Parameters",
            "Parameters of the muscle law; an empty value is the default next to the unit.",
            columns=("Parameter", "Value", "Unit, default, meaning"),
            widths=(4, 2, 5),
            rows=6,
        ),
        Input(
            "delete_muscle", "button", "Delete muscle", "Deletes the muscle and all of its points."
        ),
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
            "Click the points that the muscle passes through, in order: vertices, sketch points, "
            "construction points, or the centres of circles, spheres and tori.",
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
            "Points of the muscle, in order, at the pose of the design. Edit the coordinates to "
            "move a point.",
            columns=("No.", "Link", "x, y, z [mm]"),
            widths=(1, 3, 4),
            rows=8,
            children=_TABLE_BUTTONS,
        ),
        Input("length", "text", "Length", "Length at the pose of the design."),
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
        Input("wrap_name", "string", "Name", "Name of the surface in all files."),
        Input("wrap_link", "dropdown", "Link", "The link that the surface is fixed to."),
        Input(
            "wrap_uses",
            "table",
            "Muscles",
            "Muscles that wrap over this surface, and the point before the surface.",
            columns=("Muscle", "After point", "Side", "Turns"),
            widths=(3, 2, 3, 2),
            rows=6,
            children=(
                Input("use_add", "button", "Add", "Adds the muscle of the first tab."),
                Input("use_delete", "button", "Delete", "Removes the selected muscle."),
            ),
        ),
        Input(
            "wrap_delete", "button", "Delete surface", "Deletes the wrap surface but not the face."
        ),
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
            "Task points are controlled or reported; markers are tracked by cameras.",
            options=(TASK, MARKER),
            value=TASK,
        ),
        Input(
            "other_pick",
            "selection",
            "Points",
            "Click the points; their names can be edited in the table.",
            filters=_POINTS,
            prompt="Pick a task point or marker",
        ),
        Input(
            "others",
            "table",
            "Points",
            "All task points and markers.",
            columns=("Type", "Name", "Link"),
            widths=(2, 3, 3),
            rows=8,
            children=(Input("other_delete", "button", "Delete", "Deletes the selected point."),),
        ),
    ),
)

_TOOLS = Input(
    "tab_tools",
    "tab",
    "Mirror, links",
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
                    "Mirror plane: a plane through the origin of the design, or a picked plane.",
                    options=(*PLANES, PICKED_PLANE),
                    value=next(iter(PLANES)),
                ),
                Input(
                    "plane_pick",
                    "selection",
                    "Picked plane",
                    "A flat face or a construction plane.",
                    filters=("PlanarFaces", "ConstructionPlanes"),
                    prompt="Pick the mirror plane",
                ),
                Input(
                    "mirror_all",
                    "check",
                    "All muscles of this side",
                    "Mirrors all muscles of this side instead of only the chosen one.",
                ),
                Input(
                    "mirror_replace",
                    "check",
                    "Replace",
                    "Replaces existing muscles of the other side.",
                ),
                Input(
                    "mirror",
                    "button",
                    "Mirror",
                    "The sides of links and muscles are marked by l, left, r or right at the "
                    "beginning or end of a name: arm_l and arm_r, LeftArm and RightArm.",
                ),
            ),
        ),
        Input(
            "links_group",
            "group",
            "Replace a link",
            children=(
                Input("old_link", "dropdown", "Link", "The link that points and surfaces name."),
                Input(
                    "new_link",
                    "dropdown",
                    "By",
                    "Another link, or the link of the part that each point lies on.",
                    options=(OF_PART,),
                    value=OF_PART,
                ),
                Input(
                    "replace_link",
                    "button",
                    "Replace",
                    "Moves all points and wrap surfaces of the link at once, for example after "
                    "a link was renamed.",
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
            columns=("Name", "Min. [N]", "Max. [N]", "Muscle law", "Points, length"),
            widths=(4, 2, 2, 4, 4),
            rows=16,
            children=(
                Input(
                    "paste",
                    "button",
                    "Paste",
                    "Imports cells copied from a spreadsheet, including points. Muscles, task "
                    "points and markers with the same names are replaced.",
                ),
                Input("copy", "button", "Copy", "Copies all points for a spreadsheet."),
                Input("csv_import", "button", "Import ...", "Imports a CSV file."),
                Input("csv_export", "button", "Export ...", "Writes all points to a CSV file."),
            ),
        ),
    ),
)

_MOTION = Input(
    "tab_motion",
    "tab",
    "Motion",
    children=(
        Input("motion_joint", "dropdown", "Joint", "The joint that moves.", options=(NO_JOINT,)),
        Input(
            "motion_percent",
            "number",
            "Position [%]",
            "Position in the range of the joint: 0 is its lower limit, 100 its upper limit. Parts "
            "of the design do not move.",
        ),
        Input("motion_at", "text", "Position", "Position and range of the joint."),
        Input(
            "motion",
            "table",
            "Muscles",
            "Length of each muscle at this position, its change since the pose of the design, and "
            "its moment arm: torque at the joint per unit of muscle force.",
            columns=("Muscle", "Length", "Change [mm]", "Arm [mm]", "Arm over the range [mm]"),
            widths=(3, 3, 2, 2, 5),
            rows=16,
        ),
    ),
)

DIALOG = Dialog(
    id="cardsflowDefineMuscles",
    folder="define_muscles",
    name="Define muscles",
    tooltip="Defines muscles by the points that they pass through.",
    description="Each point belongs to the link of the clicked part. Muscles, task points, markers "
    "and wrap surfaces are stored in the design. The rest of the design is not changed. One undo "
    "reverts everything.",
    size=(520, 640),
    edits=True,
    inputs=(
        _MUSCLES,
        _ALL,
        _WRAPS,
        _OTHERS,
        _TOOLS,
        _MOTION,
        Input("undo", "button", "Undo", "Reverts the last edit in this dialog."),
        Input("redo", "button", "Redo", "Repeats the edit that was undone last."),
        Input("status", "text", "Status", "Last action, and why OK is disabled.", rows=4),
    ),
)
