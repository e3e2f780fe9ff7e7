"""Parameters of a robot and its sensors that can be calibrated, with their priors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Literal

import numpy as np

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.checks.muscles import MAX_FRICTION
from addin_sdfusion.robot.model.muscle_laws import law_parameters
from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import moving_frames
from sim_dart.estimation.estimated_robot import cable_compliances, passive_muscles

from .inertia import NUMBERS, InertiaPrior, inertia_of, thicken
from .markers import Marker

Kind = Literal[
    "point",
    "offset",
    "stiffness",
    "cable_friction",
    "inertia",
    "damping",
    "friction",
    "armature",
    "gain",
    "tension_delay",
    "length_delay",
    "marker",
]

GROUPS = {
    "muscles": ("offset", "via_points", "stiffness", "friction"),
    "links": ("inertia",),
    "joints": ("damping", "friction"),
    "motors": ("armature", "gain"),
    "delays": ("tensions", "lengths"),
    "markers": ("position",),
}
"""Parameters that can be calibrated: the last word of their names by the first word."""

_DELAYS: tuple[tuple[str, Kind], ...] = (
    ("delays.tensions", "tension_delay"),
    ("delays.lengths", "length_delay"),
)
_NONE = -1
MIN_FRICTION = 1e-4
"""Smallest friction coefficient of a cable. A cable without friction has no friction states."""


INERTIA_SD = 0.3
"""Relative standard deviation of the prior of the density of a link; see `InertiaPrior`."""

_VIA_POINT_SD = 3e-3  # in [m]
_OFFSET_SD = 5e-3  # in [m]
_DELAY_SD = 3e-3  # in [s]
_MARKER_SD = 1e-2  # in [m]
_STIFFNESS_SD, _CABLE_FRICTION_SD, _GAIN_SD = 0.3, 0.3, 0.05  # relative
_JOINT_SD = 0.1  # of damping, friction and armature, relative to the torques of the recording


@dataclass(frozen=True)
class Parameter:
    """Free parameter, represented by its change.

    Attributes:
        name: Name, such as `muscles.biceps.via_points[1].x`.
        item: Index of its muscle, link or coordinate.
        part: Indices of the via point and axis, or index of the number of an inertia.
        value: Value of the original robot, in `unit`; 0 for parameters of sensors.
        sd: Standard deviation of the prior.
        low, high: Smallest and largest value.
    """

    name: str
    kind: Kind
    item: int
    part: tuple[int, ...]
    value: float
    sd: float
    unit: str
    low: float = -math.inf
    high: float = math.inf

    @property
    def group(self) -> str:
        """Name of its muscle, link or coordinate, such as `muscles.biceps`."""
        return self.name.rpartition(".")[0].partition(".via_points")[0].partition(".inertia")[0]


def free_parameters(
    robot: Robot,
    patterns: Sequence[str],
    torque: FloatArray,
    markers: Sequence[Marker] = (),
) -> tuple[tuple[Parameter, ...], tuple[str, ...]]:
    """Return the parameters that match patterns, and a note for each pattern without match.

    Args:
        robot: A valid robot.
        patterns: Patterns such as `muscles.*.offset`; see `GROUPS`.
        torque: Typical torque of each coordinate in the recording, shape (n,).
        markers: Motion-capture markers.

    Raises:
        InputError: A pattern does not match any kind of parameter.
    """
    offered = {key: list(group) for key, group in _all_parameters(robot, torque)}
    for k, marker in enumerate(markers):
        key = f"markers.{marker.name}.position"
        places = zip("xyz", marker.position, strict=True)
        offered[key] = [
            Parameter(f"{key}.{axis}", "marker", k, (a,), value, _MARKER_SD, "m")
            for a, (axis, value) in enumerate(places)
        ]
    chosen, notes = [], []
    for pattern in patterns:
        keys = [key for key in offered if fnmatchcase(key, pattern)]
        words = pattern.split(".")
        last = words[-1] if len(words) > 1 else "*"
        matching = [kind for kind in GROUPS.get(words[0], ()) if fnmatchcase(kind, last)]
        if not keys and not (matching and "*" in pattern):
            offers = ", ".join(f"{g}.*.{kind}" for g, kinds in GROUPS.items() for kind in kinds)
            raise InputError(f"unknown parameter {pattern!r}; known: {offers}", key="--parameters")
        if not keys:
            notes.append(f"{pattern}: this robot does not have such a parameter")
        chosen += keys
    parameters = [parameter for key in offered if key in chosen for parameter in offered[key]]
    if not parameters:
        raise InputError("matches no parameter that can be calibrated", key="--parameters")
    return tuple(parameters), tuple(notes)


def _all_parameters(
    robot: Robot, torque: FloatArray
) -> Iterator[tuple[str, Iterator[Parameter] | list[Parameter]]]:
    """Generate all parameters, with the name that is compared with patterns."""
    passive, compliance = passive_muscles(robot), cable_compliances(robot)
    for k, muscle in enumerate(robot.muscles):
        name = f"muscles.{muscle.name}"
        yield f"{name}.via_points", _via_point_parameters(robot, k)
        if passive[k]:
            continue
        offset = Parameter(f"{name}.offset", "offset", k, (), 0.0, _OFFSET_SD, "m")
        yield f"{name}.offset", [offset]
        if compliance[k]:
            stiffness = 1.0 / compliance[k]
            key, sd = f"{name}.stiffness", _STIFFNESS_SD * stiffness
            yield key, [Parameter(key, "stiffness", k, (), stiffness, sd, "N/m")]
        if muscle.friction and muscle.bend_friction:
            key, sd = f"{name}.friction", _CABLE_FRICTION_SD * muscle.friction
            bounds = MIN_FRICTION, MAX_FRICTION
            mu = muscle.friction
            yield key, [Parameter(key, "cable_friction", k, (), mu, sd, "1", *bounds)]
        key = f"motors.{muscle.name}.gain"
        yield key, [Parameter(key, "gain", k, (), 1.0, _GAIN_SD, "1")]
    moving = moving_frames(robot)[1]
    for k, link in enumerate(robot.links):
        if moving[link.name].frame >= 0 and link.inertia.mass > 0:
            name = f"links.{link.name}.inertia"
            yield name, _inertia_parameters(name, k, link.inertia)
    yield from _joint_parameters(robot, torque)
    for key, kind in _DELAYS:
        yield key, [Parameter(key, kind, _NONE, (), 0.0, _DELAY_SD, "s")]


def _via_point_parameters(robot: Robot, k: int) -> Iterator[Parameter]:
    muscle = robot.muscles[k]
    for i, point in enumerate(muscle.via_points):
        for a, axis in enumerate("xyz"):
            name = f"muscles.{muscle.name}.via_points[{i}].{axis}"
            value = point.position[a]
            yield Parameter(name, "point", k, (i, a), value, _VIA_POINT_SD, "m")


def _inertia_parameters(name: str, k: int, inertia: Inertia) -> list[Parameter]:
    thick = thicken(inertia)
    sds = InertiaPrior(thick, INERTIA_SD).sd.tolist()
    rows = zip(NUMBERS.items(), thick.tolist(), sds, strict=True)
    return [
        Parameter(f"{name}.{signal}", "inertia", k, (i,), value, sd, unit)
        for i, ((signal, unit), value, sd) in enumerate(rows)
    ]


def _joint_parameters(robot: Robot, torque: FloatArray) -> Iterator[tuple[str, list[Parameter]]]:
    for j, c in enumerate(robot.coordinates):
        scale = _JOINT_SD * float(torque[j])
        of = "N.m" if c.unit == "rad" else "N"
        losses: tuple[tuple[Kind, float, str], ...] = (
            ("damping", c.damping, f"{of}.s/{c.unit}"),
            ("friction", c.friction, of),
        )
        for kind, value, unit in losses:
            key, sd = f"joints.{c.name}.{kind}", max(0.5 * value, scale)
            yield key, [Parameter(key, kind, j, (), value, sd, unit, 0.0)]
        if c.actuated:
            key, sd = f"motors.{c.name}.armature", max(0.5 * c.armature, scale)
            unit = "kg.m2" if c.unit == "rad" else "kg"
            yield key, [Parameter(key, "armature", j, (), c.armature, sd, unit, 0.0)]


def calibrated_robot(robot: Robot, parameters: Sequence[Parameter], theta: FloatArray) -> Robot:
    """Return the robot with changed parameters. Parameters of sensors are ignored."""
    links, muscles, coordinates = list(robot.links), list(robot.muscles), list(robot.coordinates)
    inertias: dict[int, FloatArray] = {}
    for one, change in zip(parameters, theta.tolist(), strict=True):
        k, value = one.item, one.value + change
        if not change:
            continue
        if one.kind == "point":
            muscles[k] = _with_moved_point(muscles[k], one.part[0], one.part[1], change)
        elif one.kind == "inertia":
            inertias.setdefault(k, np.zeros(10))[one.part[0]] = change
        elif one.kind in ("damping", "friction", "armature"):
            coordinates[k] = replace(coordinates[k], **{one.kind: value})
        elif one.kind == "stiffness":
            numbers = dict(law_parameters(muscles[k].model)) | {"stiffness": value}
            model = replace(muscles[k].model, parameters=tuple(numbers.items()))
            muscles[k] = replace(muscles[k], model=model)
        elif one.kind == "cable_friction":
            muscles[k] = replace(muscles[k], friction=value)
    for k, numbers_changed in inertias.items():
        inertia = inertia_of(thicken(links[k].inertia) + numbers_changed)
        links[k] = replace(links[k], inertia=inertia)
    by_name = {c.name: c for c in coordinates}
    joints = (j.map_coordinates(lambda c: by_name.get(c.name, c)) for j in robot.joints)
    changed = replace(robot, links=tuple(links), joints=tuple(joints))
    return changed.with_muscles(muscles) if robot.cable_set else changed


def _with_moved_point(muscle: Muscle, point: int, axis: int, change: float) -> Muscle:
    """Return a muscle whose via point is moved along an axis of its link."""
    via = list(muscle.via_points)
    x, y, z = (p + change * (a == axis) for a, p in enumerate(via[point].position))
    via[point] = replace(via[point], position=(x, y, z))
    return replace(muscle, via_points=tuple(via))
