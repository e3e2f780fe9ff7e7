"""Checks of swivelling pulleys, in every cable set."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..caspr_vocabulary import CASPR_PULLEYS
from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, unknown, warning
from ..model.laws import MUSCLE_LAWS
from ..model.link_poses import initial_poses
from ..model.muscle import BasePulley, Muscle
from ..model.muscle_laws import law_of
from ..model.pose import Pose, Vector3
from ..model.robot import Robot
from ..model.rotations import apply, compose, inverse, subtract

_BEARING_PARAMETERS = ("inertia", "bearing_friction")
_WITH_DRUM = [law.kind for law in MUSCLE_LAWS.values() if law.has_drum]
MAX_RADIUS = 4.0
"""Maximum radius of a pulley, in [m]; pulleys of cableways have up to 3 m."""


def pulleys(robot: Robot) -> Iterator[Finding]:
    """Check size, direction, next via point and bearing of each pulley."""
    for subject, muscle in all_muscles(robot):
        if muscle.pulley is None:
            continue
        findings = [*_names(subject, muscle.pulley), *_numbers(subject, muscle.pulley)]
        yield from findings
        if not findings:
            yield from _next_point(subject, muscle, muscle.pulley)
            yield from _bearing(subject, muscle, muscle.pulley)


def _names(subject: Subject, pulley: BasePulley) -> Iterator[Finding]:
    caspr_pulley = next(p for p in CASPR_PULLEYS.values() if p.kind == pulley.kind)
    names = [*(item.tag for item in caspr_pulley.properties), *_BEARING_PARAMETERS]
    for name, _ in pulley.parameters:
        if name not in names:
            problem = f"its pulley: {unknown('parameter', name, names)}"
            yield error(subject, "unknown-pulley-parameter", problem)


def _numbers(subject: Subject, pulley: BasePulley) -> Iterator[Finding]:
    radius, entry = pulley.radius, pulley.entry_vector
    if len(radius) != 1 or radius[0] <= 0.0:
        problem = f"pulley_radius {_text(radius)} of its base pulley must be one positive number"
        yield error(subject, "bad-pulley", problem)
    elif radius[0] > MAX_RADIUS:
        problem = f"pulley_radius {_text(radius)} m of its base pulley is above {MAX_RADIUS:g} m; "
        yield error(subject, "bad-pulley", problem + "is it in mm?")
    if len(entry) != 3 or not any(entry):
        problem = f"{pulley.entry_name} {_text(entry)} of its base pulley must be a nonzero vector"
        yield error(subject, "bad-pulley", problem)
    parameters = dict(pulley.parameters)
    for name in _BEARING_PARAMETERS:
        values = parameters.get(name, (0.0,))
        if len(values) != 1 or values[0] < 0.0:
            problem = f"{name} {_text(values)} of its pulley must be one number, not negative"
            yield error(subject, "bad-pulley", problem)


def _next_point(subject: Subject, muscle: Muscle, pulley: BasePulley) -> Iterator[Finding]:
    """Check that the next via point is outside the pulley if both are on the same link."""
    points = muscle.via_points[:2]
    if len(points) < 2 or points[0].link != points[1].link or any(p.moves for p in points):
        return
    if _is_inside(pulley, points[0].position, points[1].position):
        problem = f"its via point 2 is inside its pulley of radius {pulley.radius[0]:g} m"
        yield error(subject, "point-in-pulley", problem)


def reached_points(robot: Robot) -> Iterator[Finding]:
    """Check next via points on other links, in the initial pose of a robot without errors."""
    poses: dict[str, Pose] = {}
    for subject, muscle in all_muscles(robot):
        points, pulley = muscle.via_points[:2], muscle.pulley
        if pulley is None or points[0].link == points[1].link or any(p.moves for p in points):
            continue
        poses = poses or initial_poses(robot)
        T_pulley_next = compose(inverse(poses[points[0].link]), poses[points[1].link])
        if _is_inside(pulley, points[0].position, apply(T_pulley_next, points[1].position)):
            problem = (
                f"its via point 2 is inside its pulley of radius {pulley.radius[0]:g} m "
                "in the initial pose; the pulley is shrunk to reach it"
            )
            yield warning(subject, "point-reaches-pulley", problem)


def _is_inside(pulley: BasePulley, start: Vector3, end: Vector3) -> bool:
    """Return whether a point is inside the pulley circle, which swivels into its direction.

    Both points are in the pulley's frame.
    """
    offset = subtract(end, start)
    size = math.hypot(*pulley.entry_vector)
    along = sum(w * v for w, v in zip(offset, pulley.entry_vector, strict=True)) / size
    distance = math.hypot(*offset)
    across = math.sqrt(max(distance**2 - along**2, 0.0))
    return math.hypot(along, across - pulley.radius[0]) < pulley.radius[0]


def _bearing(subject: Subject, muscle: Muscle, pulley: BasePulley) -> Iterator[Finding]:
    names = [name for name in _BEARING_PARAMETERS if pulley.number(name)]
    if names and not law_of(muscle.model).has_drum:
        problem = f"{' and '.join(names)} of its pulley require a winch; use the muscle law "
        problem += f"{' or '.join(_WITH_DRUM)}, or remove them"
        yield error(subject, "pulley-without-winch", problem)


def _text(numbers: tuple[float, ...]) -> str:
    return " ".join(map(repr, numbers)) or "(not given)"
