"""Checks of the muscles' paths and force bounds, in every cable set."""

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

MAX_FRICTION, MAX_PRESLIDING = 2.0, 0.1
"""Largest coefficient of friction of a cable; dry rubber has about 1."""


def has_muscles(robot: Robot) -> Iterator[Finding]:
    """Something drives it: the active cable set, or a motor."""
    active = [group for group in robot.cable_sets if group.name == robot.cable_set]
    if robot.motors:
        return
    if not robot.cable_set or (active and not active[0].muscles):
        problem = "no muscles and no motors; only the joints' own forces move it"
        yield warning(Subject("robot", robot.name), "no-muscles", problem)


def via_points(robot: Robot) -> Iterator[Finding]:
    """Muscles have two points at least, on links that exist, and every segment has a length."""
    links = [link.name for link in robot.links]
    known = {WORLD, *links}
    for subject, muscle in all_muscles(robot):
        points = muscle.via_points
        if len(points) < 2 and (points or not muscle.terms):
            problem = f"needs at least two via points, has {len(points)}"
            yield error(subject, "too-few-via-points", problem)
        for name in dict.fromkeys(point.link for point in points):
            if name not in known:
                problem = f"via point on {unknown('link', name, [WORLD, *links])}"
                yield error(subject, "unknown-via-link", problem)
        for i, (start, end) in enumerate(pairwise(points), start=1):
            if replace(start, friction=end.friction) == end and muscle.is_segment(i - 1):
                problem = f"via points {i} and {i + 1} are the same point of link {start.link!r}"
                yield error(subject, "zero-length-segment", problem)


def moment_arms(robot: Robot) -> Iterator[Finding]:
    """Muscles connect bodies that move against each other."""
    bodies = _bodies(robot)
    surfaces = {surface.name: surface.link for surface in robot.wrap_surfaces}
    for subject, muscle in all_muscles(robot):
        links = [point.link for point in muscle.via_points]
        links += [surfaces[w.surface] for w in muscle.wraps if w.surface in surfaces]
        on = {bodies.get(link, link) for link in links}
        if len(muscle.via_points) > 1 and len(on) == 1 and not muscle.terms:
            problem = "all of its path is on one rigid body, so it moves nothing"
            yield warning(subject, "no-moment-arm", problem)


def force_limits(robot: Robot) -> Iterator[Finding]:
    """Muscles pull, and their limits are in order."""
    for subject, muscle in all_muscles(robot):
        if muscle.f_min < 0.0:
            problem = f"f_min {muscle.f_min!r} is negative; a cable cannot push"
            yield error(subject, "negative-force", problem)
        if muscle.f_min > muscle.f_max:
            problem = f"f_min {muscle.f_min!r} is above f_max {muscle.f_max!r}"
            yield error(subject, "force-limits-reversed", problem)
        if muscle.f_max == math.inf and law_of(muscle.model).kind == "ideal":
            problem = "no maximum force is given; set f_max to the largest allowed force"
            yield warning(subject, "no-force-limit", problem)


def cable_models(robot: Robot) -> Iterator[Finding]:
    """Active muscles whose cable or pulley is kept but not simulated; a spring takes no command."""
    for subject, muscle in all_muscles(robot):
        if muscle.model.kind == "passive_spring" and (muscle.f_min, muscle.f_max) != (0.0, 0.0):
            problem = "a passive spring takes no command; set f_min and f_max to 0"
            yield error(subject, "passive-cable-force", problem)
        yield from _friction(subject, muscle)
        yield from _hanging(subject, muscle)
        if subject.name == muscle.name:  # one of the active set
            yield from _not_simulated(subject, muscle)


def _not_simulated(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    kind = muscle.model.kind
    if kind not in MUSCLE_LAWS:
        problem = f"a {kind} cable; it is simulated as an ideal one, whose force is as commanded"
        problem += _stretch(muscle)
        yield warning(subject, "cable-model-not-simulated", problem)
    if muscle.pulley is not None and muscle.pulley.kind == "screw":
        yield warning(subject, "winch-travel-left-out", _travel(muscle.pulley))


def _friction(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    for where, mu in _coefficients(muscle):
        if mu < 0.0 or mu > MAX_FRICTION:
            problem = f"friction {mu!r}{where} must be from 0 to {MAX_FRICTION:g}"
            problem += "; cables in Bowden tubes and guides have 0.05 to 0.2"
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
    """Where a coefficient is given, and what it is."""
    yield "", muscle.friction
    for k, point in enumerate(muscle.via_points, start=1):
        if point.friction is not None:
            yield f" of via point {k}", point.friction
    for wrap in muscle.wraps:
        if wrap.friction is not None:
            yield f" on surface {wrap.surface!r}", wrap.friction


def _hanging(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    """A heavy cable is free between two points."""
    if not law_of(muscle.model).sags:
        return
    points = muscle.via_points
    other = {
        f"{len(points)} via points": len(points) != 2,
        "wraps": bool(muscle.wraps),
        "a pulley": muscle.pulley is not None,
        "branches": bool(muscle.branches or muscle.terms),
        "via points that come, go or move": any(p.when is not None or p.moves for p in points),
        "friction": bool(muscle.friction or muscle.bend_friction),
    }
    found = [what for what, has in other.items() if has]
    if found:
        problem = (
            f"a {muscle.model.kind} hangs between two via points; it cannot have {', '.join(found)}"
        )
        yield error(subject, "heavy-cable-path", problem)


def _stretch(muscle: Muscle) -> str:
    """How far CASPR's spring, of stiffness K over its length, would stretch, and does not here."""
    K = dict(muscle.model.parameters).get("K", 0.0)
    if K <= 0.0 or not math.isfinite(muscle.f_max):
        return ""
    return f" (its {muscle.f_max:g} N would stretch it by {100.0 * muscle.f_max / K:.3g} %)"


def _travel(pulley: BasePulley) -> str:
    """What a screw's winch does in CASPR, and not here."""
    numbers = dict(pulley.parameters)
    given = [numbers.get(f"winch_{name}", ()) for name in ("groove_width", "radius")]
    how = ""
    if all(len(values) == 1 for values in given) and given[1][0] > 0.0:
        how = f" by {given[0][0] / (2 * math.pi * given[1][0]):.3g} m a metre of cable"
    return (
        f"its winch moves its pulley{how} in CASPR, and the start depends on the number of earlier "
        "calls; here the pulley stays at the constant winch point"
    )


def _bodies(robot: Robot) -> dict[str, str]:
    """For each link, the first link of the rigid body that it belongs to."""
    bodies = {WORLD: WORLD}
    for joint in robot.joints:
        welded = joint.type == "fixed"
        bodies[joint.child] = bodies.get(joint.parent, joint.parent) if welded else joint.child
    return bodies
