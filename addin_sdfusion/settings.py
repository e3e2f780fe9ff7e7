"""Settings of an export, stored in the design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LinkSource = Literal["auto", "rigid_groups", "components"]
Collision = Literal["none", "mesh", "convex_hull", "box", "sphere", "cylinder"]
UpAxis = Literal["z", "y"]
MeshQuality = Literal["low", "normal", "high", "very_high"]


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """Settings of one link.

    Attributes:
        link: Name of the link.
        collision: Its collision geometry; None for the geometry that all links use.
        mass: Its mass in [kg], which scales its inertia; None for the mass in the design.
        name: Its name in the exported files; if empty, the name in the design.
    """

    link: str
    collision: Collision | None = None
    mass: float | None = None
    name: str = ""

    @property
    def exported_name(self) -> str:
        """Name of the link in the exported files."""
        return self.name or self.link


@dataclass(frozen=True, slots=True)
class JointSettings:
    """Settings of one joint; None keeps the value of the design.

    Attributes:
        joint: Name of the joint, or of its coordinate if it has several, such as `shoulder_pitch`.
        effort: Maximum torque or force of its motor, in [N·m] or [N].
        damping: Viscous damping, in [N·m·s/rad] or [N·s/m].
        friction: Coulomb friction, in [N·m] or [N].
        velocity: Maximum velocity, in [rad/s] or [m/s].
        reversed: Whether the coordinate is positive in the opposite direction of the design.
    """

    joint: str
    effort: float | None = None
    damping: float | None = None
    friction: float | None = None
    velocity: float | None = None
    reversed: bool = False


@dataclass(frozen=True, slots=True)
class ExportSettings:
    """Settings for writing the robot folder of a design.

    Attributes:
        name: Name of the robot; if empty, the name of the design.
        links: The source of links: rigid groups called `EXPORT_<link>`; components; or `auto`,
            which uses rigid groups if the design has any, otherwise components.
        components: Full paths of the occurrences that become links, or their names if unique, if
            components are links; if empty, the top-level occurrences.
        base: Name of the link at the root of the tree; if empty, it is found automatically.
        fixed_base: Whether the base is fixed to the world; otherwise it floats.
        cut_joints: Names of the joints at which closed loops are cut. They are exported as loop
            joints, which have no coordinates; if empty, they are found automatically.
        up_axis: Axis of the design that points up; gravity acts in the opposite direction.
        visual: Whether to write visual meshes.
        collision: Collision geometry of the links.
        quality: How fine the meshes are.
        caspr: Whether to write CASPR's files.
        osim: Whether to write OpenSim's file.
        urdf: Whether to write a URDF.
        mjcf: Whether to write MuJoCo's MJCF.
        folder: Folder of the last export; empty before the first one.
        of_links: Settings of single links.
        of_joints: Settings of single joints.
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
        """Return the collision geometry of a link, by its name in the exported files."""
        collisions = [each.collision for each in self.of_links if each.exported_name == link]
        return next((shape for shape in collisions if shape is not None), self.collision)

    @property
    def needs_meshes(self) -> bool:
        """Whether the export requires the meshes of the bodies."""
        collisions = {self.collision, *(chosen.collision for chosen in self.of_links)}
        return self.visual or bool(collisions - {None, "none"})
