"""Checks of the functions between coordinates and motions, and of couplings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from ..finding import Finding, Subject
from ..finding_builders import error, finite, listed, unknown, warning
from ..model.function import Function, Polynomial, cubics
from ..model.joint import Coordinate
from ..model.robot import Robot

MAX_NUMBERS = 10_000
"""Maximum number of coefficients or points of a function."""
MAX_VALUE = 1e100
"""Maximum absolute value of a coefficient of a spline segment."""


def functions(robot: Robot) -> Iterator[Finding]:
    """Check that functions have finite numbers and points with increasing x."""
    for joint in robot.joints:
        for motion in joint.motions:
            fault = function_fault(motion.function)
            if fault:
                yield error(Subject("joint", joint.name), "bad-function", f"a motion's {fault}")
        for c in joint.coordinates:
            for term in c.coupling:
                fault = function_fault(term.function)
                if fault:
                    yield error(Subject("coordinate", c.name), "bad-function", f"its {fault}")


def function_fault(function: Function) -> str:
    """Return the description of the error in a function, or an empty string."""
    if isinstance(function, Polynomial):
        if not 1 <= len(function.coefficients) <= MAX_NUMBERS:
            return f"polynomial has {len(function.coefficients)} coefficients"
        return "" if finite(function.coefficients) else "polynomial has a number that is not finite"
    if len(function.x) != len(function.y) or not 2 <= len(function.x) <= MAX_NUMBERS:
        return f"function has {len(function.x)} x and {len(function.y)} y; give at least two pairs"
    if not finite(function.x) or not finite(function.y):
        return "function has a number that is not finite"
    if any(not a < b for a, b in pairwise(function.x)):
        return "function has x values that do not increase"
    try:
        sound = all(abs(number) < MAX_VALUE for piece in cubics(function) for number in piece)
    except (ZeroDivisionError, OverflowError):
        sound = False
    return "" if sound else "function has points that are too close together for finite slopes"


def couplings(robot: Robot) -> Iterator[Finding]:
    """Check that coupled coordinates follow existing coordinates and do not form a cycle."""
    coordinates = {c.name: c for c in robot.all_coordinates}
    for c in coordinates.values():
        subject = Subject("coordinate", c.name)
        for term in c.coupling:
            if term.coordinate not in coordinates:
                problem = f"follows {unknown('coordinate', term.coordinate, list(coordinates))}"
                yield error(subject, "unknown-coordinate", problem)
        if not c.is_free and c.actuated:
            problem = (
                "has a motor, but is coupled or locked; move the motor to the coordinate that it "
                "follows"
            )
            yield error(subject, "motor-not-free", problem)
        if c.locked and c.coupling:
            yield error(subject, "locked-and-coupled", "is locked and coupled; keep one of the two")
        if c.locked and not math.isfinite(c.initial):
            continue
        if c.coupling and any(math.isfinite(limit) for limit in (c.lower, c.upper)):
            problem = (
                "is coupled: its limits are ignored; set limits on the coordinates that it follows"
            )
            yield warning(subject, "limits-of-coupled", problem)
    for cycle in _cycles(coordinates):
        problem = f"follows itself through {listed(cycle)}; remove one of the couplings"
        yield error(Subject("coordinate", cycle[0]), "coupling-circle", problem)


def resisting(robot: Robot) -> Iterator[Finding]:
    """Check that limit forces have ordered ranges and no negative parameters."""
    for c in robot.all_coordinates:
        force, subject = c.limit_force, Subject("coordinate", c.name)
        if force is None:
            continue
        if not force.low <= force.high:
            problem = f"limit force: low {force.low!r} is above high {force.high!r}"
            yield error(subject, "limit-force-reversed", problem)
        for parameter in ("stiffness_low", "stiffness_high", "damping", "inertia"):
            if getattr(force, parameter) < 0.0:
                problem = f"limit force: {parameter} {getattr(force, parameter)!r} is negative"
                yield error(subject, "negative-limit-force", problem)
        if not force.transition > 0.0:
            problem = f"limit force: transition {force.transition!r} must be positive"
            yield error(subject, "limit-force-transition", problem)


def _cycles(coordinates: dict[str, Coordinate]) -> Iterator[list[str]]:
    """Yield the first cycle of couplings, as the names of its coordinates."""
    done: set[str] = set()
    for name in coordinates:
        path: list[str] = []
        stack: list[str | None] = [name]
        while stack:
            current = stack.pop()
            if current is None:
                done.add(path.pop())
            elif current in path:
                yield path[path.index(current) :]
                return
            elif current in coordinates and current not in done:
                path.append(current)
                stack += [None, *(term.coordinate for term in coordinates[current].coupling)]
