"""User's settings of an export, kept in the design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LinkSource = Literal["auto", "rigid_groups", "components"]
Collision = Literal["none", "mesh", "convex_hull"]
UpAxis = Literal["z", "y"]
MeshQuality = Literal["low", "normal", "high", "very_high"]


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """How a design becomes a robot folder.

    Attributes:
        name: The robot's name; the design's if empty.
        links: What becomes a link: rigid groups called `EXPORT_<link>`; components; or `auto`, the
            rigid groups where the design has any, else components.
        components: Full paths of the occurrences that become links, where components do; the
            top-level ones if empty.
        base: Name of the link that the tree starts from; found if empty.
        fixed_base: Whether the base is fixed to the world; else it floats.
        cut_joints: Names of joints to leave out, so that closed loops become trees.
        up_axis: The design's axis that points up; gravity is its opposite.
        visual: Whether to write meshes of what links look like.
        collision: What links collide with.
        quality: How fine the meshes are.
        caspr: Whether to write CASPR's files.
        osim: Whether to write OpenSim's file.
        folder: The folder exported to last; empty if there was none.
    """

    name: str = ""
    links: LinkSource = "auto"
    components: tuple[str, ...] = ()
    base: str = ""
    fixed_base: bool = True
    cut_joints: tuple[str, ...] = ()
    up_axis: UpAxis = "z"
    visual: bool = True
    collision: Collision = "convex_hull"
    quality: MeshQuality = "normal"
    caspr: bool = True
    osim: bool = True
    folder: str = ""
