"""Muscles: cables through via points, over wrap surfaces, in alternative sets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from .placement import IDENTITY, Pose, Vector3

CableKind = Literal[
    "ideal", "linear_spring", "passive_spring", "vsd_torsion", "vsd_flexure", "vsd_polynomial"
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
    """How a cable's force, length and stiffness belong together.

    Everything but `ideal` is kept in the description and simulated as ideal: `check` says so.

    Attributes:
        kind: `ideal` (force as commanded), `linear_spring`, `passive_spring` (no actuator), or one
            of CASPR's variable-stiffness cables.
        parameters: Its numbers by the names and in the units of CASPR's files.
    """

    kind: CableKind = "ideal"
    parameters: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class BasePulley:
    """A swivelling pulley where a cable leaves the base.

    The first via point is the pulley's fixed location. The arc on the pulley and the exit point
    that moves with it are not modelled: `check` says so.

    Attributes:
        kind: `rotating`, or `screw` with a winch behind it.
        parameters: Its numbers by the names and in the units of CASPR's files, vectors in a row.
    """

    kind: Literal["rotating", "screw"]
    parameters: tuple[tuple[str, tuple[float, ...]], ...] = ()


@dataclass(frozen=True, slots=True)
class WrapSurface:
    """A surface that muscles may wrap over.

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
    """A muscle's way over a wrap surface.

    The path is simulated straight, as if the surface were not there: `check` says so.

    Attributes:
        surface: Name of the surface.
        segment: Index of the via point before it.
        side: 1 or -1 for a chosen sense of turning about the axis, 0 for the shorter way.
        turns: Whole turns about it.
    """

    surface: str
    segment: int
    side: Literal[-1, 0, 1] = 0
    turns: int = 0


@dataclass(frozen=True, slots=True)
class Muscle:
    """A cable that pulls along straight segments through its via points.

    Attributes:
        name: Its name, unique in its cable set.
        via_points: At least two, in order.
        f_min: Smallest force that a controller may command, in [N].
        f_max: Largest force, in [N]; infinite where unknown.
        model: How force, length and stiffness belong together.
        pulley: A swivelling pulley at its first via point, if there is one.
        wraps: Surfaces on its way, in order.
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
