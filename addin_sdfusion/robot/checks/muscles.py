"""Checks of muscle paths and force limits, in every cable set."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, unknown, warning
from ..model.laws import MUSCLE_LAWS
from ..model.muscle import BasePulley, Muscle
from ..model.muscle_laws import law_of
from ..model.robot import WORLD, Robot
from .loops import rigid_bodies

MAX_FRICTION, MAX_PRESLIDING = 2.0, 0.1
"""Maximum coefficient of cable friction (dry rubber has about 1), and maximum presliding in [m]."""


def has_muscles(robot: Robot) -> Iterator[Finding]:
    """Check that the robot has muscles in the active cable set, or motors."""
    active = [group for group in robot.cable_sets if group.name == robot.cable_set]
    if robot.motors:
        return
    if not robot.cable_set or (active and not active[0].muscles):
        problem = "no muscles and no motors; only gravity and passive joint forces move it"
        yield warning(Subject("robot", robot.name), "no-muscles", problem)


def via_points(robot: Robot) -> Iterator[Finding]:
    """Check that muscles have at least two via points on existing links, and no empty segment."""
    links = [link.name for link in robot.links]
    link_names = {WORLD, *links}
    for subject, muscle in all_muscles(robot):
        points = muscle.via_points
        if len(points) < 2 and (points or not muscle.terms):
            problem = f"needs at least two via points, has {len(points)}"
            yield error(subject, "too-few-via-points", problem)
        for name in dict.fromkeys(point.link for point in points):
            if name not in link_names:
                problem = f"via point on {unknown('link', name, [WORLD, *links])}"
                yield error(subject, "unknown-via-link", problem)
        for i, (start, end) in enumerate(pairwise(points), start=1):
            if replace(start, friction=end.friction) == end and muscle.is_segment(i - 1):
                problem = f"via points {i} and {i + 1} are the same point of link {start.link!r}"
                yield error(subject, "zero-length-segment", problem)


def moment_arms(robot: Robot) -> Iterator[Finding]:
    """Check that muscles connect bodies that move relative to each other."""
    bodies = rigid_bodies(robot.joints)
    surfaces = {surface.name: surface.link for surface in robot.wrap_surfaces}
    for subject, muscle in all_muscles(robot):
        links = [point.link for point in muscle.via_points]
        links += [surfaces[w.surface] for w in muscle.wraps if w.surface in surfaces]
        on = {bodies.get(link, link) for link in links}
        if len(muscle.via_points) > 1 and len(on) == 1 and not muscle.terms:
            problem = "its complete path is on one rigid body, so it has no moment arm"
            yield warning(subject, "no-moment-arm", problem)


def force_limits(robot: Robot) -> Iterator[Finding]:
    """Check that force limits are not negative and in order."""
    for subject, muscle in all_muscles(robot):
        if muscle.f_min < 0.0:
            problem = f"f_min {muscle.f_min!r} is negative; a cable cannot push"
            yield error(subject, "negative-force", problem)
        if muscle.f_min > muscle.f_max:
            problem = f"f_min {muscle.f_min!r} is above f_max {muscle.f_max!r}"
            yield error(subject, "force-limits-reversed", problem)
        if muscle.f_max == math.inf and law_of(muscle.model).kind == "ideal":
            problem = "no maximum force is specified; set f_max to the largest allowed force"
            yield warning(subject, "no-force-limit", problem)


def cable_models(robot: Robot) -> Iterator[Finding]:
    """Check cable models, friction and sagging; warn about parts that are not simulated."""
    for subject, muscle in all_muscles(robot):
        if muscle.model.kind == "passive_spring" and (muscle.f_min, muscle.f_max) != (0.0, 0.0):
            problem = "a passive spring has no command; set f_min and f_max to 0"
            yield error(subject, "passive-cable-force", problem)
        yield from _friction(subject, muscle)
        yield from _sagging(subject, muscle)
        if subject.name == muscle.name:  # a muscle of the active set
            yield from _not_simulated(subject, muscle)


def _not_simulated(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    kind = muscle.model.kind
    if kind not in MUSCLE_LAWS:
        problem = f"a {kind} cable is simulated as an ideal cable, whose force equals the command"
        problem += _stretch_text(muscle)
        yield warning(subject, "cable-model-not-simulated", problem)
    if muscle.pulley is not None and muscle.pulley.kind == "screw":
        yield warning(subject, "winch-travel-left-out", _travel_text(muscle.pulley))


def _friction(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    for where, mu in _coefficients(muscle):
        if mu < 0.0 or mu > MAX_FRICTION:
            problem = f"friction {mu!r}{where} must be from 0 to {MAX_FRICTION:g}"
            problem += "; typical values for Bowden tubes and guides are 0.05 to 0.2"
            yield error(subject, "bad-cable-friction", problem)
    for k, point in enumerate(muscle.via_points, start=1):
        is_end = k == len(muscle.via_points) or (k == 1 and muscle.pulley is None)
        if is_end and point.friction is not None:
            problem = f"friction of via point {k} has no effect at the end of a cable"
            yield warning(subject, "idle-cable-friction", problem)
    if not 0.0 < muscle.presliding <= MAX_PRESLIDING:
        problem = (
            f"presliding {muscle.presliding!r} must be above 0 m and at most {MAX_PRESLIDING:g} m"
        )
        problem += "; typical values are 0.0001 to 0.0005"
        yield error(subject, "bad-cable-friction", problem)


def _coefficients(muscle: Muscle) -> Iterator[tuple[str, float]]:
    """Yield the location and the value of each specified coefficient of friction."""
    yield "", muscle.friction
    for k, point in enumerate(muscle.via_points, start=1):
        if point.friction is not None:
            yield f" of via point {k}", point.friction
    for wrap in muscle.wraps:
        if wrap.friction is not None:
            yield f" on surface {wrap.surface!r}", wrap.friction


def _sagging(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    """Check that a heavy cable hangs freely between two points."""
    if not law_of(muscle.model).sags:
        return
    points = muscle.via_points
    features = {
        f"{len(points)} via points": len(points) != 2,
        "wraps": bool(muscle.wraps),
        "a pulley": muscle.pulley is not None,
        "branches": bool(muscle.branches or muscle.terms),
        "conditional or moving via points": any(p.when is not None or p.moves for p in points),
        "friction": bool(muscle.friction or muscle.bend_friction),
    }
    used = [feature for feature, is_used in features.items() if is_used]
    if used:
        problem = (
            f"a {muscle.model.kind} hangs between two via points; it cannot have {', '.join(used)}"
        )
        yield error(subject, "heavy-cable-path", problem)


def _stretch_text(muscle: Muscle) -> str:
    """Return the stretch that CASPR's spring, of stiffness K over its length, would have."""
    K = dict(muscle.model.parameters).get("K", 0.0)
    if K <= 0.0 or not math.isfinite(muscle.f_max):
        return ""
    return f" (f_max {muscle.f_max:g} N would stretch it by {100.0 * muscle.f_max / K:.3g} %)"


def _travel_text(pulley: BasePulley) -> str:
    """Return the warning that the travel of a screw winch is not simulated."""
    numbers = dict(pulley.parameters)
    screw = [numbers.get(f"winch_{name}", ()) for name in ("groove_width", "radius")]
    how = ""
    if all(len(values) == 1 for values in screw) and screw[1][0] > 0.0:
        how = f" by {screw[0][0] / (2 * math.pi * screw[1][0]):.3g} m per metre of cable"
    return (
        f"in CASPR the winch moves its pulley{how}, from a start that depends on the number of "
        "earlier calls; here the pulley stays at the constant winch point"
    )
