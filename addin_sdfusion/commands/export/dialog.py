"""The dialog of Export."""

from __future__ import annotations

from ...settings import Collision, LinkSource, MeshQuality, UpAxis
from ..dialogs import Dialog, Input

LINKS: dict[str, LinkSource] = {
    "Rigid groups, else components": "auto",
    "Rigid groups EXPORT_<link>": "rigid_groups",
    "Components": "components",
}
UP: dict[str, UpAxis] = {"z": "z", "y": "y"}
COLLISIONS: dict[str, Collision] = {
    "Convex hull": "convex_hull",
    "The visual mesh": "mesh",
    "Box": "box",
    "Sphere": "sphere",
    "Cylinder": "cylinder",
    "None": "none",
}
QUALITIES: dict[str, MeshQuality] = {
    "Low": "low",
    "Normal": "normal",
    "High": "high",
    "Very high": "very_high",
}
FOUND = "Found by itself"
AS_ALL = "As all"

DIALOG = Dialog(
    id="cardsflowExport",
    folder="export",
    name="Export",
    tooltip="The design as a robot folder that simulates at once.",
    description="Writes SDF, meshes, CARDSflow, CASPR and OpenSim files and an experiment for "
    "'cardsflow run'. The choices are kept in the design.",
    inputs=(
        Input("name", "string", "Robot's name", "Of the folder's files; the design's if empty."),
        Input(
            "folder",
            "string",
            "Folder",
            "The add-in replaces its own files in it and leaves all others alone.",
        ),
        Input("browse", "button", "Choose the folder ...", "Opens the dialog for folders."),
        Input(
            "links_group",
            "group",
            "Links and joints",
            children=(
                Input(
                    "links",
                    "dropdown",
                    "Links are",
                    "What becomes a link of the robot.",
                    options=tuple(LINKS),
                    value=next(iter(LINKS)),
                ),
                Input(
                    "components",
                    "selection",
                    "Components",
                    "The components that become links, with everything in them; the top-level ones "
                    "if none is picked.",
                    filters=("Occurrences",),
                    prompt="Pick the components that become links",
                ),
                Input(
                    "base",
                    "dropdown",
                    "Base",
                    "The link that the tree of joints starts from.",
                    options=(FOUND,),
                    value=FOUND,
                ),
                Input(
                    "fixed_base",
                    "check",
                    "Base is fixed to the world",
                    "Else it floats.",
                    value=True,
                ),
                Input(
                    "cut_joints",
                    "choices",
                    "Joints to cut",
                    "The robot must be a tree: choose one joint of each closed loop to leave out.",
                ),
                Input(
                    "up_axis",
                    "dropdown",
                    "Up",
                    "The design's axis that points up; gravity is its opposite.",
                    options=tuple(UP),
                    value="z",
                ),
            ),
        ),
        Input(
            "files_group",
            "group",
            "Files",
            children=(
                Input(
                    "visual",
                    "check",
                    "Meshes to look at",
                    "One STL file a link, in metres.",
                    value=True,
                ),
                Input(
                    "collision",
                    "dropdown",
                    "Collision",
                    "What links collide with: simple shapes are about each body.",
                    options=tuple(COLLISIONS),
                    value=next(iter(COLLISIONS)),
                ),
                Input(
                    "quality",
                    "dropdown",
                    "Mesh quality",
                    "Finer meshes are larger and slower.",
                    options=tuple(QUALITIES),
                    value="Normal",
                ),
                Input(
                    "caspr", "check", "CASPR", "Bodies, cables and operational space.", value=True
                ),
                Input("osim", "check", "OpenSim", "An .osim model.", value=True),
                Input("urdf", "check", "URDF", "In a folder of its own, with the meshes."),
                Input("mjcf", "check", "MuJoCo", "MJCF in a folder of its own, with the meshes."),
            ),
        ),
        Input(
            "single_group",
            "group",
            "Single links and joints",
            collapsed=True,
            children=(
                Input(
                    "of_links",
                    "table",
                    "Links",
                    "What is otherwise for one link. An empty mass is that of the design; another "
                    "one scales its inertia.",
                    columns=("Link", "Collision", "Mass [kg]"),
                    widths=(3, 3, 2),
                    rows=6,
                ),
                Input(
                    "of_joints",
                    "table",
                    "Joints",
                    "Largest torque or force of the joint's motor, viscous damping and friction, "
                    "in SI units; those of the design where empty.",
                    columns=("Joint", "Effort", "Damping", "Friction"),
                    widths=(3, 2, 2, 2),
                    rows=6,
                ),
            ),
        ),
        Input("status", "text", "Findings", "Errors keep OK grey; Check lists all.", rows=6),
    ),
    ok="Export",
    size=(440, 680),
)
