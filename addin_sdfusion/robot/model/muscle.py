"""Muscles: cables through via points, over wrap surfaces, in alternative sets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from .pose import IDENTITY, Pose, Vector3

CableKind = Literal[
    "ideal",
    "elastic_cable",
    "series_elastic_motor",
    "mckibben",
    "hill_degroote2016",
    "hill_millard2012",
    "hill_thelen2003",
    "ligament_blankevoort1991",
    "passive_spring",
    "linear_spring",
    "vsd_torsion",
    "vsd_flexure",
    "vsd_polynomial",
]
WrapShape = Literal["sphere", "cylinder"]


@dataclass(frozen=True, slots=True)
class ViaPoint:
    """A point that a muscle passes through.

    Attributes:
        link: The link it is fixed to, or `WORLD`.
        position: In that link's frame, in [m].
    """

    link: str
    position: Vector3


@dataclass(frozen=True, slots=True)
class CableModel:
    """How a muscle's tension follows from its command, length and speed.

    The laws of `tension_laws` are simulated. CASPR's `linear_spring` and variable-stiffness cables
    are kept in the description and simulated as ideal, as CASPR does it: `check` says so.

    Attributes:
        kind: `ideal` (force as commanded), another law, or one of CASPR's cables.
        parameters: Its numbers by name, in SI units; of CASPR's cables by the names of its files.
    """

    kind: CableKind = "ideal"
    parameters: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class BasePulley:
    """A swivelling pulley where a cable leaves the base.

    The first via point is where the cable comes on, along the entry vector; the pulley's plane
    swivels about that line to hold the next point. The arc on the pulley, of `pulley_radius`,
    counts for the length, and the cable leaves along the tangent. The winch of a screw moves its
    pulley along in CASPR, by a way that depends on how often it was called; here it stands still:
    `check` says so.

    Attributes:
        kind: `rotating`, or `screw` with a winch behind it.
        parameters: Its numbers by the names and in the units of CASPR's files, vectors in a row.
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


@dataclass(frozen=True, slots=True)
class WrapSurface:
    """A surface that muscles may wrap over.

    A cylinder's ends are taken as tapered: where the straight line between the via points passes
    the axis beyond an end, the radius that counts falls to zero within one radius. So a cable
    slips off an end without a jump of its length.

    Attributes:
        name: Its name, unique among the wrap surfaces.
        link: The link it is fixed to, or `WORLD`.
        shape: `sphere` or `cylinder`; a cylinder's axis is the z axis of its pose.
        radius: In [m].
        pose: In the link's frame.
        length: Of a cylinder, in [m]; infinite where it has no ends.
    """

    name: str
    link: str
    shape: WrapShape
    radius: float
    pose: Pose = IDENTITY
    length: float = math.inf


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

    Attributes:
        surface: Name of the surface.
        segment: Index of the via point before it.
        side: 1 or -1 for a chosen sense of turning about the surface's z axis, 0 for the shorter
            path.
        turns: Whole turns about it, besides.
        inside: Whether it passes inside the surface; then it has no side and no turns.
    """

    surface: str
    segment: int
    side: Literal[-1, 0, 1] = 0
    turns: int = 0
    inside: bool = False


@dataclass(frozen=True, slots=True)
class Muscle:
    """A cable that is taut through its via points and over its wrap surfaces.

    Attributes:
        name: Its name, unique in its cable set.
        via_points: At least two, in order.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite where unknown.
        model: How force, length and stiffness belong together.
        pulley: A swivelling pulley at its first via point, if there is one.
        wraps: Wraps over surfaces, in order.
    """

    name: str
    via_points: tuple[ViaPoint, ...]
    f_min: float = 0.0
    f_max: float = math.inf
    model: CableModel = CableModel()
    pulley: BasePulley | None = None
    wraps: tuple[Wrap, ...] = ()


@dataclass(frozen=True, slots=True)
class CableSet:
    """A named, complete set of muscles; a robot has one or more and uses one at a time."""

    name: str
    muscles: tuple[Muscle, ...]
