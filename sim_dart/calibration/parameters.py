"""Numbers of a robot and of its sensors that a calibration may free, with their priors."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import Literal

import numpy as np

from addin_sdfusion.robot import Coordinate, InputError, Robot
from addin_sdfusion.robot.checks.muscles import MAX_FRICTION
from addin_sdfusion.robot.model.muscle_laws import law_parameters
from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import moving_frames
from sim_dart.estimation.estimated_robot import cable_compliances, passive_muscles

from .inertia import NUMBERS, InertiaPrior, inertia_of, thickened
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
"""What can be freed, by the first word of its name and the last."""

_NONE = -1
MIN_FRICTION = 1e-4
"""Of a cable: with none it would have no bends."""


@dataclass(frozen=True)
class PriorSettings:
    """How far numbers may be from what the robot's files say: standard deviations.

    Attributes:
        via_points: In [m].
        offset: In [m].
        stiffness, gain, mu: Relative; mu is the friction of cables.
        inertia: Relative, of a link's density; see `InertiaPrior`.
        friction: Of damping, friction and armature: over the torques of the recording.
        delay: In [s].
        marker: Of its position on its link, in [m].
    """

    via_points: float = 3e-3
    offset: float = 5e-3
    stiffness: float = 0.3
    gain: float = 0.05
    mu: float = 0.3
    inertia: float = 0.3
    friction: float = 0.1
    delay: float = 3e-3
    marker: float = 1e-2


@dataclass(frozen=True)
class Parameter:
    """A free number, as a change of what the robot has.

    Attributes:
        name: Such as `muscles.biceps.via_points[1].x`.
        kind: What it is.
        item: Index of its muscle, link or coordinate.
        part: Index of the point, and of the axis; or of the number of an inertia.
        value: Of the robot, in `unit`; 0 if it is a change by itself.
        sd: Of the prior.
        unit: Its unit.
        low, high: Least and greatest value.
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
        """What it belongs to, such as `muscles.biceps`."""
        return self.name.rpartition(".")[0].partition(".via_points")[0].partition(".inertia")[0]


def free_parameters(
    robot: Robot,
    patterns: Sequence[str],
    torque: FloatArray,
    priors: PriorSettings,
    markers: Sequence[Marker] = (),
) -> tuple[tuple[Parameter, ...], tuple[str, ...]]:
    """Return the parameters that patterns name, and a line each for what there is none of.

    Args:
        robot: A valid robot.
        patterns: Such as `muscles.*.offset`; what they may say is in `GROUPS`.
        torque: Typical torques of the recording, of each coordinate, shape (n,).
        priors: How far they may be off.
        markers: Of motion capture.

    Raises:
        InputError: A pattern names nothing that any robot has.
    """
    every = {key: list(made) for key, made in _every(robot, torque, priors)}
    for k, marker in enumerate(markers):
        key = f"markers.{marker.name}.position"
        places = zip("xyz", marker.position, strict=True)
        every[key] = [
            Parameter(f"{key}.{axis}", "marker", k, (a,), value, priors.marker, "m")
            for a, (axis, value) in enumerate(places)
        ]
    chosen, notes = [], []
    for pattern in patterns:
        found = [key for key in every if fnmatchcase(key, pattern)]
        words = pattern.split(".")
        last = words[-1] if len(words) > 1 else "*"
        known = [kind for kind in GROUPS.get(words[0], ()) if fnmatchcase(kind, last)]
        if not found and not (known and "*" in pattern):
            offers = ", ".join(f"{g}.*.{kind}" for g, kinds in GROUPS.items() for kind in kinds)
            raise InputError(f"unknown parameter {pattern!r}; known: {offers}", key="--parameters")
        if not found:
            notes.append(f"{pattern}: this robot has none")
        chosen += found
    parameters = [one for key in every if key in chosen for one in every[key]]
    if not parameters:
        raise InputError("matches no parameter that can be calibrated", key="--parameters")
    return tuple(parameters), tuple(notes)


def _every(
    robot: Robot, torque: FloatArray, priors: PriorSettings
) -> Iterator[tuple[str, Iterator[Parameter] | list[Parameter]]]:
    """All that can be free, by the name that patterns are compared with."""
    passive, compliance = passive_muscles(robot), cable_compliances(robot)
    for k, muscle in enumerate(robot.muscles):
        name = f"muscles.{muscle.name}"
        yield f"{name}.via_points", _points(robot, k, priors)
        if passive[k]:
            continue
        offset = Parameter(f"{name}.offset", "offset", k, (), 0.0, priors.offset, "m")
        yield f"{name}.offset", [offset]
        if compliance[k]:
            stiffness = 1.0 / compliance[k]
            key, sd = f"{name}.stiffness", priors.stiffness * stiffness
            yield key, [Parameter(key, "stiffness", k, (), stiffness, sd, "N/m")]
        if muscle.friction and muscle.bend_friction:
            key, sd = f"{name}.friction", priors.mu * muscle.friction
            bounds = MIN_FRICTION, MAX_FRICTION
            mu = muscle.friction
            yield key, [Parameter(key, "cable_friction", k, (), mu, sd, "1", *bounds)]
        key = f"motors.{muscle.name}.gain"
        yield key, [Parameter(key, "gain", k, (), 1.0, priors.gain, "1")]
    moving = moving_frames(robot)[1]
    for k, link in enumerate(robot.links):
        if moving[link.name].frame >= 0 and link.inertia.mass > 0:
            name = f"links.{link.name}.inertia"
            yield name, _numbers(name, k, link.inertia, priors)
    yield from _of_joints(robot, torque, priors)
    delays: tuple[tuple[str, Kind], ...] = (
        ("tensions", "tension_delay"),
        ("lengths", "length_delay"),
    )
    for what, kind in delays:
        key = f"delays.{what}"
        yield key, [Parameter(key, kind, _NONE, (), 0.0, priors.delay, "s")]


def _points(robot: Robot, k: int, priors: PriorSettings) -> Iterator[Parameter]:
    muscle = robot.muscles[k]
    for i, point in enumerate(muscle.via_points):
        for a, axis in enumerate("xyz"):
            name = f"muscles.{muscle.name}.via_points[{i}].{axis}"
            value = point.position[a]
            yield Parameter(name, "point", k, (i, a), value, priors.via_points, "m")


def _numbers(name: str, k: int, inertia: Inertia, priors: PriorSettings) -> list[Parameter]:
    believed = thickened(inertia)
    sds = InertiaPrior(believed, priors.inertia).sd.tolist()
    rows = zip(NUMBERS.items(), believed.tolist(), sds, strict=True)
    return [
        Parameter(f"{name}.{what}", "inertia", k, (i,), value, sd, unit)
        for i, ((what, unit), value, sd) in enumerate(rows)
    ]


def _of_joints(
    robot: Robot, torque: FloatArray, priors: PriorSettings
) -> Iterator[tuple[str, list[Parameter]]]:
    for j, c in enumerate(robot.coordinates):
        scale = priors.friction * float(torque[j])
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
    """Return the robot with its numbers changed; those of sensors are none of it.

    Args:
        robot: As it was believed to be.
        parameters: The free ones.
        theta: How each has changed, shape (P,).
    """
    points: dict[tuple[int, int], list[float]] = {}
    inertias: dict[int, FloatArray] = {}
    joints: dict[str, dict[str, float]] = {}
    stiff: dict[int, float] = {}
    rough: dict[int, float] = {}
    for one, change in zip(parameters, theta.tolist(), strict=True):
        if not change:
            continue
        if one.kind == "point":
            key = (one.item, one.part[0])
            moved = points.setdefault(
                key, list(robot.muscles[one.item].via_points[key[1]].position)
            )
            moved[one.part[1]] += change
        elif one.kind == "inertia":
            inertias.setdefault(one.item, np.zeros(10))[one.part[0]] = change
        elif one.kind in ("damping", "friction", "armature"):
            name = robot.coordinates[one.item].name
            joints.setdefault(name, {})[one.kind] = one.value + change
        elif one.kind == "stiffness":
            stiff[one.item] = one.value + change
        elif one.kind == "cable_friction":
            rough[one.item] = one.value + change
    return _changed(robot, points, inertias, joints, stiff, rough)


def _changed(
    robot: Robot,
    points: dict[tuple[int, int], list[float]],
    inertias: dict[int, FloatArray],
    joints: dict[str, dict[str, float]],
    stiff: dict[int, float],
    rough: dict[int, float],
) -> Robot:
    links = list(robot.links)
    for k, theta in inertias.items():
        believed = thickened(links[k].inertia)
        links[k] = replace(links[k], inertia=inertia_of(believed + theta))
    muscles = list(robot.muscles)
    for k in {k for k, _ in points}:
        via = list(muscles[k].via_points)
        for i, (x, y, z) in ((i, at) for (of, i), at in points.items() if of == k):
            via[i] = replace(via[i], position=(x, y, z))
        muscles[k] = replace(muscles[k], via_points=tuple(via))
    for k, stiffness in stiff.items():
        model = muscles[k].model
        numbers = dict(law_parameters(model)) | {"stiffness": stiffness}
        model = replace(model, parameters=tuple(numbers.items()))
        muscles[k] = replace(muscles[k], model=model)
    for k, mu in rough.items():
        muscles[k] = replace(muscles[k], friction=mu)
    moved = tuple(
        replace(
            joint, coordinates=tuple(_with(c, joints.get(c.name, {})) for c in joint.coordinates)
        )
        for joint in robot.joints
    )
    changed = replace(robot, links=tuple(links), joints=moved)
    return changed.with_muscles(muscles) if robot.cable_set else changed


def _with(c: Coordinate, values: Mapping[str, float]) -> Coordinate:
    return replace(
        c,
        damping=values.get("damping", c.damping),
        friction=values.get("friction", c.friction),
        armature=values.get("armature", c.armature),
    )
