"""Dialog of Export."""

from __future__ import annotations

from ...settings import Collision, LinkSource, MeshQuality, UpAxis
from ..dialogs import Dialog, Input

LINKS: dict[str, LinkSource] = {
    "Rigid groups or components": "auto",
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
FOUND = "Automatic"
AS_ALL = "Default"

DIALOG = Dialog(
    id="cardsflowExport",
    folder="export",
    name="Export",
    tooltip="Exports the design to a robot folder that can be simulated.",
    description="Writes SDF, meshes, CARDSflow, CASPR and OpenSim files. 'cardsflow init' then "
    "adds an experiment. The settings are stored in the design.",
    inputs=(
        Input("name", "string", "Robot name", "Name of the robot (default: name of the design)."),
        Input(
            "folder",
            "string",
            "Folder",
            "Target folder. Only files of earlier exports are replaced.",
        ),
        Input("browse", "button", "Choose the folder ...", "Opens a dialog to choose the folder."),
        Input(
            "links_group",
            "group",
            "Links and joints",
            children=(
                Input(
                    "links",
                    "dropdown",
                    "Links are",
                    "Objects of the design that become links of the robot.",
                    options=tuple(LINKS),
                    value=next(iter(LINKS)),
                ),
                Input(
                    "components",
                    "selection",
                    "Components",
                    "The components that become links, including their contents (default: the "
                    "top-level components).",
                    filters=("Occurrences",),
                    prompt="Pick the components that become links",
                ),
                Input(
                    "base",
                    "dropdown",
                    "Base",
                    "The link at the root of the kinematic tree.",
                    options=(FOUND,),
                    value=FOUND,
                ),
                Input(
                    "fixed_base",
                    "check",
                    "Base is fixed to the world",
                    "Otherwise the base floats.",
                    value=True,
                ),
                Input(
                    "cut_joints",
                    "choices",
                    "Joints to cut",
                    "The joints that close loops, one of each loop; they have no coordinates "
                    "(default: found automatically).",
                ),
                Input(
                    "up_axis",
                    "dropdown",
                    "Up",
                    "Axis of the design that points up, opposite to gravity.",
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
                    "Visual meshes",
                    "One STL file per link, in metres.",
                    value=True,
                ),
                Input(
                    "collision",
                    "dropdown",
                    "Collision",
                    "Collision geometry of links. Simple shapes enclose each body.",
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
                Input("urdf", "check", "URDF", "URDF in a separate folder, with the meshes."),
                Input("mjcf", "check", "MuJoCo", "MJCF in a separate folder, with the meshes."),
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
                    "Settings of single links. An empty mass is the mass of the design; another "
                    "mass scales the inertia. An empty name is the name in the design.",
                    columns=("Link", "Collision", "Mass [kg]", "Exported as"),
                    widths=(3, 3, 2, 3),
                    rows=6,
                ),
                Input(
                    "of_joints",
                    "table",
                    "Joints",
                    "Maximum torque or force of the motor, viscous damping, friction and maximum "
                    "velocity, in SI units. Empty values are the values of the design. A reversed "
                    "joint is positive in the opposite direction.",
                    columns=("Joint", "Effort", "Damping", "Friction", "Velocity", "Direction"),
                    widths=(3, 2, 2, 2, 2, 3),
                    rows=6,
                ),
            ),
        ),
        Input("status", "text", "Findings", "Errors disable OK; Check lists them all.", rows=6),
    ),
    ok="Export",
    size=(440, 680),
)
