"""User's settings of an export, kept in the design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LinkSource = Literal["auto", "rigid_groups", "components"]
Collision = Literal["none", "mesh", "convex_hull", "box", "sphere", "cylinder"]
UpAxis = Literal["z", "y"]
MeshQuality = Literal["low", "normal", "high", "very_high"]


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """What is chosen for one link.

    Attributes:
        link: Its name.
        collision: What it collides with; None for what all do.
        mass: Its mass in place of the design's, in [kg], its inertia in proportion; None for that.
    """

    link: str
    collision: Collision | None = None
    mass: float | None = None


@dataclass(frozen=True, slots=True)
class JointSettings:
    """What is chosen for one joint, in place of the design's; None for that.

    Attributes:
        joint: Its name; of one that has several motions, of its coordinate: `shoulder_pitch`.
        effort: Largest torque or force of its motor, in [N·m] or [N].
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        friction: Coulomb friction, in [N·m] or [N].
    """

    joint: str
    effort: float | None = None
    damping: float | None = None
    friction: float | None = None


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
        urdf: Whether to write a URDF.
        mjcf: Whether to write MuJoCo's MJCF.
        folder: The folder exported to last; empty if there was none.
        of_links: What is chosen for single links.
        of_joints: What is chosen for single joints.
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
    urdf: bool = False
    mjcf: bool = False
    folder: str = ""
    of_links: tuple[LinkSettings, ...] = ()
    of_joints: tuple[JointSettings, ...] = ()

    def collision_of(self, link: str) -> Collision:
        """What a link collides with."""
        own = [chosen.collision for chosen in self.of_links if chosen.link == link]
        return next((collision for collision in own if collision is not None), self.collision)

    @property
    def needs_meshes(self) -> bool:
        """Whether anything is made of the bodies' meshes."""
        collisions = {self.collision, *(chosen.collision for chosen in self.of_links)}
        return self.visual or bool(collisions - {None, "none"})
