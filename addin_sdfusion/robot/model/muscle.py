"""Muscles: cables through via points, over wrap surfaces, in alternative sets."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from .laws import MUSCLE_LAWS
from .muscle_path import Branch, CoordinateTerm, PointCondition, PointMotion
from .pose import IDENTITY, Pose, Vector3

_CASPRS = ("linear_spring", "vsd_torsion", "vsd_flexure", "vsd_polynomial")
"""Cables of CASPR that are described and not simulated."""

if TYPE_CHECKING:
    CableKind: TypeAlias = str
else:  # readers and schemas take the names from here
    CableKind = Literal[(*MUSCLE_LAWS, *_CASPRS)]
Side = Literal[-1, 0, 1]
WrapShape = Literal["sphere", "cylinder", "ellipsoid"]
WrapRule = Literal["taut", "mujoco", "opensim"]
Quadrant = Literal["all", "+x", "-x", "+y", "-y", "+z", "-z"]


@dataclass(frozen=True, slots=True)
class ViaPoint:
    """A point that a muscle passes through.

    Attributes:
        link: The link it is fixed to, or `WORLD`.
        position: In that link's frame, in [m].
        when: When the muscle passes through it; None for always.
        moves: How it moves on the link, next to its position; none for a fixed point.
        friction: The cable's coefficient in its bend there, on its pulley at the first point; None
            for the muscle's.
    """

    link: str
    position: Vector3
    when: PointCondition | None = None
    moves: tuple[PointMotion, ...] = ()
    friction: float | None = None


@dataclass(frozen=True, slots=True)
class CustomMuscleLaw:
    """A tension custom law: a class in a Python file.

    Attributes:
        file: The file.
        name: The class.
        command: What drives it: name, unit, least and greatest value; None for a passive one.
    """

    file: str
    name: str
    command: tuple[str, str, float, float] | None


@dataclass(frozen=True, slots=True)
class CableModel:
    """How a muscle's tension follows from its command, length and speed.

    The laws of `laws` are simulated. CASPR's `linear_spring` and variable-stiffness cables
    are kept in the description and simulated as ideal, as CASPR does it: `check` reports it.

    Attributes:
        kind: `ideal` (force as commanded), another law, or one of CASPR's cables.
        parameters: Its numbers by name, in SI units; of CASPR's cables by the names of its files.
        own: A custom law, in the kind's place; it comes from an experiment, no robot's file
            has it.
    """

    kind: CableKind = "ideal"
    parameters: tuple[tuple[str, float], ...] = ()
    custom: CustomMuscleLaw | None = None


@dataclass(frozen=True, slots=True)
class BasePulley:
    """A swivelling pulley where a cable begins, at the base or on a link.

    The first via point is where the cable comes on, along the entry vector; the pulley's plane
    swivels about that line to hold the next point. The arc on the pulley, of `pulley_radius`,
    counts for the length, and the cable leaves along the tangent. The winch of a screw moves its
    pulley along in CASPR, by a way that depends on how often it was called; here it stands still:
    `check` reports it.

    Attributes:
        kind: `rotating`, or `screw` with a winch behind it.
        parameters: Its numbers by the names and in the units of CASPR's files, vectors in a row;
            and `inertia` about its axis in [kg m^2] and `bearing_friction` in [N m], which the
            winch behind it bears.
    """

    kind: Literal["rotating", "screw"]
    parameters: tuple[tuple[str, tuple[float, ...]], ...] = ()

    @property
    def entry_name(self) -> str:
        """What CASPR calls the direction in which the cable comes on."""
        return "cable_pulley_entry_vector" if self.kind == "screw" else "cable_entry_vector"

    @property
    def entry_vector(self) -> tuple[float, ...]:
        """The direction in which the cable comes on; empty if it is not given."""
        return dict(self.parameters).get(self.entry_name, ())

    @property
    def radius(self) -> tuple[float, ...]:
        """The pulley's radius, in [m]; empty if it is not given."""
        return dict(self.parameters).get("pulley_radius", ())

    def number(self, name: str) -> float:
        """Return a number that may be left out: 0 then."""
        return dict(self.parameters).get(name, (0.0,))[0]


@dataclass(frozen=True, slots=True)
class WrapSurface:
    """A surface that muscles may wrap over.

    A cylinder's ends are taken as tapered: where the straight line between the via points passes
    the axis beyond an end, the radius that counts falls to zero within one radius. So a cable
    slips off an end without a jump of its length.

    Over an ellipsoid the cable is taut along a geodesic, the shortest one: where two are as short,
    its direction jumps, but not its length.

    Attributes:
        name: Its name, unique among the wrap surfaces.
        link: The link it is fixed to, or `WORLD`.
        shape: `sphere`, `cylinder` or `ellipsoid`; a cylinder's axis is the z axis of its pose.
        radius: In [m]; of an ellipsoid, its half axis along x.
        pose: In the link's frame.
        length: Of a cylinder, in [m]; infinite if it has no ends.
        half_axes: Of an ellipsoid, the half axes along y and z, in [m]; unused for other shapes.
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

    A cable is straight as long as its straight line clears the surface. Else it goes round it
    along the shorter path, or on the chosen side, be it the longer path; coming off the surface
    changes its length smoothly, except that a cable on the longer path slips off with a jump where
    its straight line gets clear. With whole turns it never comes off. A via point inside the
    surface has it shrink so that it passes through the point.

    Several surfaces in a segment are passed in their order, and the cable is taut over all of them.
    On which chosen side it passes each is judged by the straight line between the via points;
    spheres are then passed along the shorter path. Past two spheres there can be more than one taut
    path, and the length jumps where the cable comes to another one: cylinders hold it better.

    Inside a surface, as through a ring or a sheath, a cable is straight as long as its straight
    line passes through it, or begins or ends in it. Else it touches the surface from within at one
    point, smoothly. A cylinder's ends do not count there.

    Models of other programs keep these programs' rules on whether and on which side a cable goes
    round; the way itself is the shortest on that side, and it is straight where an end is inside:

    * `mujoco`: without a side point as the straight line decides. With one outside of the surface,
      on its side: also where the straight line clears the surface on the other side. With one
      inside, the cable is led through the surface. Cylinders have no ends.
    * `opensim`: in the quadrant `all` as the straight line decides, else in the half of space that
      the quadrant says; over an ellipsoid only where the straight line meets it, and of several
      shortest paths along one that touches it in that half. A cylinder is left where the cable
      touches it beyond its ends only. Of the segments up to `last_segment` the cable goes round in
      the first whose straight line meets the surface, else, and over a sphere in the quadrant
      `all`, in the one that becomes longer by the least.

    Attributes:
        surface: Name of the surface.
        segment: Index of the via point before it.
        side: 1 or -1 for a chosen sense of turning about the surface's z axis, 0 for the shorter
            path.
        turns: Whole turns about it, besides.
        inside: Whether it passes inside the surface; then it has no side and no turns.
        rule: Whose rules it goes by: `taut` for those of above, the only ones with side, turns and
            inside; or `mujoco` or `opensim`.
        side_point: Of MuJoCo's rules, the site that says the side; None if there is none.
        quadrant: Of OpenSim's rules, the half of space about the surface's pose that it passes in.
        last_segment: Index of the via point before the last segment that it may be in, where there
            are several, by OpenSim's rules; None for `segment` alone.
        friction: The cable's coefficient on this surface; None for the muscle's.
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
        """Index of the via point before the last segment that it may be in."""
        return self.segment if self.last_segment is None else self.last_segment


_Bend = TypeVar("_Bend", ViaPoint, Wrap)

PRESLIDING = 2e-4
"""Way over which friction of a cable turns round where nothing is given, in [m]."""


@dataclass(frozen=True, slots=True)
class Muscle:
    """A cable that is taut through its via points and over its wrap surfaces.

    Attributes:
        name: Its name, unique in its cable set.
        via_points: At least two, in order; none for a length of terms alone.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite if unknown.
        model: How force, length and stiffness belong together.
        pulley: A swivelling pulley at its first via point, if there is one.
        wraps: Wraps over surfaces, in order.
        branches: Where the path begins again, in order; none for a path in one piece.
        terms: What is added to the length of the path in proportion to coordinates.
        friction: Coulomb's coefficient of the cable on its guides: over an angle theta its tension
            changes by up to exp(friction theta), where a via point or a wrap has none of its own.
            The first via point is the driven end.
        presliding: Way over which that friction turns round when the cable does, in [m].
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
        """Whether it is nothing but straight segments between all of its via points, which stay."""
        moving = any(point.when is not None or point.moves for point in self.via_points)
        plain = not moving and not self.branches and bool(self.via_points)
        return plain and not self.wraps and self.pulley is None

    @property
    def bend_friction(self) -> tuple[float, ...]:
        """Coefficients of its bends along the path; none if all are 0.

        Bends are the via points but the ends, the pulley at its first one, and the wraps.
        """
        own: list[float | None] = []
        for k, point in enumerate(self.via_points[:-1]):
            if k or self.pulley is not None:
                own.append(point.friction)
            own += [wrap.friction for wrap in self.wraps if wrap.segment == k]
        found = tuple(self.friction if mu is None else mu for mu in own)
        return found if any(found) else ()

    def with_friction_scaled(self, factor: float) -> Muscle:
        """Return the same with all of its coefficients of friction times a factor."""

        def scaled(bend: _Bend) -> _Bend:
            own = bend.friction
            return bend if own is None else replace(bend, friction=factor * own)

        return replace(
            self,
            friction=factor * self.friction,
            via_points=tuple(map(scaled, self.via_points)),
            wraps=tuple(map(scaled, self.wraps)),
        )

    def is_segment(self, k: int) -> bool:
        """Return whether the path leads from via point k to the next one."""
        return all(branch.point != k + 1 for branch in self.branches)


@dataclass(frozen=True, slots=True)
class CableSet:
    """A named, complete set of muscles; a robot has one or more and uses one at a time."""

    name: str
    muscles: tuple[Muscle, ...]
