"""Muscles: cables through via points, over wrap surfaces, in alternative sets."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from .laws import MUSCLE_LAWS
from .muscle_path import Branch, CoordinateTerm, PointCondition, PointMotion
from .pose import IDENTITY, Pose, Vector3

_CASPRS = ("linear_spring", "vsd_torsion", "vsd_flexure", "vsd_polynomial")
"""Cables of CASPR that can be described but are not simulated."""

if TYPE_CHECKING:
    CableKind: TypeAlias = str
else:  # readers and schemas use the names of this Literal
    CableKind = Literal[(*MUSCLE_LAWS, *_CASPRS)]
Side = Literal[-1, 0, 1]
PulleyKind = Literal["rotating", "screw"]
WrapShape = Literal["sphere", "cylinder", "ellipsoid"]
WrapRule = Literal["taut", "mujoco", "opensim"]
Quadrant = Literal["all", "+x", "-x", "+y", "-y", "+z", "-z"]


@dataclass(frozen=True, slots=True)
class ViaPoint:
    """A point that a muscle passes through.

    Attributes:
        link: Link of the point, or `WORLD`.
        position: In that link's frame, in [m].
        when: Condition for the point to be active, or None for a point that is always active.
        moves: Motions of the point on its link, added to its position; empty for a fixed point.
        friction: Coefficient of cable friction at the point (of its pulley, at the first point), or
            None for the coefficient of the muscle.
    """

    link: str
    position: Vector3
    when: PointCondition | None = None
    moves: tuple[PointMotion, ...] = ()
    friction: float | None = None


@dataclass(frozen=True, slots=True)
class CustomMuscleLaw:
    """A custom muscle law: a class in a Python file.

    Attributes:
        name: Name of the class.
        command: Name, unit, minimum and maximum of the command; None for a passive law.
    """

    file: str
    name: str
    command: tuple[str, str, float, float] | None


@dataclass(frozen=True, slots=True)
class CableModel:
    """Muscle law of a muscle, with its parameters.

    The laws in `laws` are simulated. CASPR's `linear_spring` and variable-stiffness cables are
    stored and simulated as ideal cables, as in CASPR; `check` reports this.

    Attributes:
        kind: `ideal` (the force equals the command), another law, or one of CASPR's cables.
        parameters: Parameters by name, in SI units; CASPR's cables use the names of CASPR's files.
        custom: A custom law that replaces `kind`. Only experiments specify it, not robot files.
    """

    kind: CableKind = "ideal"
    parameters: tuple[tuple[str, float], ...] = ()
    custom: CustomMuscleLaw | None = None


@dataclass(frozen=True, slots=True)
class BasePulley:
    """A swivelling pulley at the start of a cable, on the base or on a link.

    The cable enters the pulley at the first via point, along the entry vector. The plane of the
    pulley swivels about this line so that it contains the next point. The length includes the arc
    on the pulley, of `pulley_radius`, and the cable leaves along the tangent. In CASPR the winch of
    a `screw` moves its pulley by a distance that depends on the number of calls. Here the pulley
    does not move; `check` reports this.

    Attributes:
        kind: `rotating`, or `screw` for a pulley with a screw winch.
        parameters: Parameters with the names and units of CASPR's files, vectors as rows. Also
            `inertia` about the axis in [kg m^2] and `bearing_friction` in [N m], which are added to
            the winch.
    """

    kind: PulleyKind
    parameters: tuple[tuple[str, tuple[float, ...]], ...] = ()

    @property
    def entry_name(self) -> str:
        """CASPR's name of the direction in which the cable enters the pulley."""
        return "cable_pulley_entry_vector" if self.kind == "screw" else "cable_entry_vector"

    @property
    def entry_vector(self) -> tuple[float, ...]:
        """Direction in which the cable enters the pulley; empty if not specified."""
        return dict(self.parameters).get(self.entry_name, ())

    @property
    def radius(self) -> tuple[float, ...]:
        """Radius of the pulley, in [m]; empty if not specified."""
        return dict(self.parameters).get("pulley_radius", ())

    def number(self, name: str) -> float:
        """Return an optional parameter, or 0 if it is not specified."""
        return dict(self.parameters).get(name, (0.0,))[0]


@dataclass(frozen=True, slots=True)
class WrapSurface:
    """A surface over which muscles can wrap.

    The ends of a cylinder are tapered: if the straight line between the via points passes the axis
    outside of an end, the effective radius decreases to zero within one radius. Therefore a cable
    slips off an end without a jump of its length.

    Over an ellipsoid the cable follows the shortest geodesic. If two geodesics are equally short,
    its direction can jump, but not its length.

    Attributes:
        name: Name, unique among the wrap surfaces.
        link: Link of the surface, or `WORLD`.
        shape: `sphere`, `cylinder` or `ellipsoid`; a cylinder's axis is the z axis of its pose.
        radius: Radius in [m]; for an ellipsoid the half axis along x.
        pose: Pose in the link's frame.
        length: Length of a cylinder, in [m]; infinite for a cylinder without ends.
        half_axes: Half axes of an ellipsoid along y and z, in [m]; None for other shapes.
    """

    name: str
    link: str
    shape: WrapShape
    radius: float
    pose: Pose = IDENTITY
    length: float = math.inf
    half_axes: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Wrap:
    """A muscle's wrap over a surface.

    If the straight line between the via points does not intersect the surface, the cable is
    straight. Otherwise it wraps around the surface along the shorter path, or on the chosen side,
    even if that path is longer. Lift-off changes the length smoothly, except on the longer path:
    there the cable slips off with a jump when the straight line becomes free. With full turns the
    cable never lifts off. If a via point is inside the surface, the surface is shrunk so that it
    passes through the point.

    Several surfaces in a segment are passed in their order, and the cable is taut over all of them.
    The straight line between the via points determines the side of each surface; spheres are passed
    along the shorter path. Over two spheres more than one taut path can exist, and the length jumps
    when the cable changes to another one. Cylinders avoid this.

    With `inside` the cable passes through the surface, as through a ring or a sheath. It is
    straight if the straight line passes through the surface, or begins or ends in it. Otherwise it
    touches the surface from inside at one point. The ends of a cylinder are ignored.

    Models of other programs use the rules of these programs for whether and on which side the cable
    wraps. The path is the shortest one on that side, and straight if an end is inside:

    * `mujoco`: Without a side point, the straight line decides. With a side point outside of the
      surface, the cable passes on that side, also if the straight line is free on the other side.
      With a side point inside, the cable passes through the surface. Cylinders have no ends.
    * `opensim`: In the quadrant `all` the straight line decides, otherwise the cable passes in the
      half space that the quadrant defines. Over an ellipsoid it wraps only if the straight line
      intersects it; if several shortest paths exist, it uses one in that half space. The cable
      lifts off a cylinder only if it touches it outside of its ends. If the wrap can be in several
      segments up to `last_segment`, it is in the first segment whose straight line intersects the
      surface. If there is no such segment, and over a sphere in the quadrant `all`, it is in the
      segment with the smallest increase in length.

    Attributes:
        segment: Index of the via point before the surface.
        side: 1 or -1 for a sense of rotation about the surface's z axis, 0 for the shorter path.
        turns: Number of additional full turns.
        inside: Whether the cable passes inside the surface; requires `side` 0 and `turns` 0.
        rule: `taut` for the rules above, the only ones that support side, turns and inside; or
            `mujoco` or `opensim`.
        side_point: Site that defines the side, with the rule `mujoco`; or None.
        quadrant: Half space in the surface's frame, with the rule `opensim`.
        last_segment: Index of the via point before the last possible segment, with the rule
            `opensim`; None if only `segment` is possible.
        friction: Coefficient of cable friction on this surface, or None for the coefficient of the
            muscle.
    """

    surface: str
    segment: int
    side: Side = 0
    turns: int = 0
    inside: bool = False
    rule: WrapRule = "taut"
    side_point: ViaPoint | None = None
    quadrant: Quadrant = "all"
    last_segment: int | None = None
    friction: float | None = None

    @property
    def last(self) -> int:
        """Index of the via point before the last possible segment."""
        return self.segment if self.last_segment is None else self.last_segment


_Bend = TypeVar("_Bend", ViaPoint, Wrap)

PRESLIDING = 2e-4
"""Default sliding distance over which the friction of a cable reverses, in [m]."""


@dataclass(frozen=True, slots=True)
class Muscle:
    """A cable that is taut through its via points and over its wrap surfaces.

    Attributes:
        name: Name, unique in the cable set.
        via_points: At least two points, in order; empty for a length that consists only of terms.
        f_min: Minimum force that a controller can command, in [N].
        f_max: Maximum force, in [N]; infinite if unknown.
        model: Muscle law with its parameters.
        pulley: Swivelling pulley at the first via point, or None.
        wraps: Wraps over surfaces, in order.
        branches: Via points at which the path begins again, in order; empty for a single piece.
        terms: Terms proportional to coordinates that are added to the length of the path.
        friction: Coefficient of Coulomb friction of the cable on its guides. Over an angle theta
            the tension changes by up to exp(friction theta). Via points and wraps can override it.
            The first via point is the driven end.
        presliding: Sliding distance over which the friction reverses, in [m].
    """

    name: str
    via_points: tuple[ViaPoint, ...]
    f_min: float = 0.0
    f_max: float = math.inf
    model: CableModel = CableModel()
    pulley: BasePulley | None = None
    wraps: tuple[Wrap, ...] = ()
    branches: tuple[Branch, ...] = ()
    terms: tuple[CoordinateTerm, ...] = ()
    friction: float = 0.0
    presliding: float = PRESLIDING

    @property
    def is_straight(self) -> bool:
        """Whether the path consists of straight segments between all via points, all fixed."""
        moving = any(point.when is not None or point.moves for point in self.via_points)
        plain = not moving and not self.branches and bool(self.via_points)
        return plain and not self.wraps and self.pulley is None

    @property
    def bend_friction(self) -> tuple[float, ...]:
        """Friction coefficients of the bends along the path; empty if all are 0.

        Bends are the inner via points, the pulley at the first via point, and the wraps.
        """
        coefficients: list[float | None] = []
        for k, point in enumerate(self.via_points[:-1]):
            if k or self.pulley is not None:
                coefficients.append(point.friction)
            coefficients += [wrap.friction for wrap in self.wraps if wrap.segment == k]
        bends = tuple(self.friction if mu is None else mu for mu in coefficients)
        return bends if any(bends) else ()

    def with_friction_scaled(self, factor: float) -> Muscle:
        """Return the muscle with all coefficients of friction multiplied by a factor."""

        def scaled(bend: _Bend) -> _Bend:
            friction = bend.friction
            return bend if friction is None else replace(bend, friction=factor * friction)

        return replace(
            self,
            friction=factor * self.friction,
            via_points=tuple(map(scaled, self.via_points)),
            wraps=tuple(map(scaled, self.wraps)),
        )

    def is_segment(self, k: int) -> bool:
        """Return whether a segment connects via point k to the next one."""
        return all(branch.point != k + 1 for branch in self.branches)


@dataclass(frozen=True, slots=True)
class CableSet:
    """A named, complete set of muscles. A robot can have several sets; one set is active."""

    name: str
    muscles: tuple[Muscle, ...]
