"""Checks of muscle paths: conditional and moving points, branches, terms and wrap rules."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import get_args

from ..finding import Finding, Subject
from ..finding_builders import all_muscles, error, finite, unknown
from ..model.muscle import Muscle, Quadrant, Wrap, WrapRule
from ..model.robot import WORLD, Robot
from .driven import function_fault


def conditions(robot: Robot) -> Iterator[Finding]:
    """Check that conditional via points have a valid range of an existing coordinate."""
    for subject, muscle in all_muscles(robot):
        for k, point in enumerate(muscle.via_points):
            if point.when is None:
                continue
            yield from _coordinate(robot, subject, point.when.coordinate, f"via point {k + 1}")
            if point.when.low > point.when.high or point.when.smoothing < 0.0:
                problem = f"via point {k + 1} is active from {point.when.low!r} to "
                problem += f"{point.when.high!r}, smoothed over {point.when.smoothing!r}; "
                problem += "the limits must increase and the smoothing must not be negative"
                yield error(subject, "bad-point-condition", problem)


def moving_points(robot: Robot) -> Iterator[Finding]:
    """Check that moving via points use valid functions of existing coordinates."""
    for subject, muscle in all_muscles(robot):
        for k, point in enumerate(muscle.via_points, start=1):
            for move in point.moves:
                yield from _coordinate(robot, subject, move.coordinate, f"via point {k}")
                fault = function_fault(move.function)
                if fault:
                    yield error(subject, "bad-function", f"via point {k}: its {fault}")
                if not move.low <= move.high or not finite(move.axis):
                    problem = f"via point {k} moves from {move.low!r} to {move.high!r} along "
                    problem += f"{move.axis!r}; the limits must increase and the axis be finite"
                    yield error(subject, "bad-point-motion", problem)


def branches(robot: Robot) -> Iterator[Finding]:
    """Check that branches are in order, with at least two via points and a nonzero divisor."""
    for subject, muscle in all_muscles(robot):
        starts, points = [branch.point for branch in muscle.branches], len(muscle.via_points)
        if starts != sorted(set(starts)) or not all(0 <= k < points for k in starts):
            problem = f"branches start at via points {starts}; these must exist and increase"
            yield error(subject, "bad-branch", problem)
        elif starts and any(last <= first for first, last in _pieces(muscle)):
            yield error(subject, "bad-branch", "a branch needs at least two via points")
        if any(branch.divisor == 0.0 for branch in muscle.branches):
            yield error(subject, "bad-branch", "a branch's divisor is 0")


def terms(robot: Robot) -> Iterator[Finding]:
    """Check that the terms of a muscle's length use existing coordinates."""
    for subject, muscle in all_muscles(robot):
        for term in muscle.terms:
            yield from _coordinate(robot, subject, term.coordinate, "term")


def wrap_rules(robot: Robot) -> Iterator[Finding]:
    """Check that wraps only use properties that their rule supports."""
    shapes = {surface.name: surface.shape for surface in robot.wrap_surfaces}
    links = [WORLD, *(link.name for link in robot.links)]
    for subject, muscle in all_muscles(robot):
        for wrap in muscle.wraps:
            for problem in _rule_problems(wrap, shapes.get(wrap.surface, "")):
                yield error(subject, "bad-wrap-rule", f"wrap over {wrap.surface!r}: {problem}")
            if wrap.side_point is not None and wrap.side_point.link not in links:
                problem = f"side point on {unknown('link', wrap.side_point.link, links)}"
                yield error(subject, "unknown-wrap-link", problem)
        yield from _wraps_per_segment(subject, muscle)
        yield from _mixed_rules(subject, muscle)


def _rule_problems(wrap: Wrap, shape: str) -> Iterator[str]:
    if wrap.rule not in get_args(WrapRule) or wrap.quadrant not in get_args(Quadrant):
        yield f"unknown rule {wrap.rule!r} or quadrant {wrap.quadrant!r}"
        return
    if wrap.rule != "taut" and (wrap.side or wrap.turns or wrap.inside):
        yield f"rule {wrap.rule!r} does not support side, turns or inside; remove them"
    if wrap.rule != "mujoco" and wrap.side_point is not None:
        yield "only rule 'mujoco' supports a side point"
    if wrap.rule != "opensim" and (wrap.quadrant != "all" or wrap.last_segment is not None):
        yield "only rule 'opensim' supports a quadrant or several segments"
    if wrap.rule == "mujoco" and shape == "ellipsoid":
        yield "rule 'mujoco' does not support ellipsoids"
    if shape == "ellipsoid" and (wrap.side or wrap.turns or wrap.inside):
        yield "an ellipsoid does not support side, turns or inside; remove them"


def _wraps_per_segment(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    counts = Counter(wrap.segment for wrap in muscle.wraps if wrap.rule == "mujoco")
    for segment, count in counts.items():
        if count > 1:
            problem = f"{count} wraps with rule 'mujoco' in segment {segment}; use at most one"
            yield error(subject, "bad-wrap-rule", problem)


def _mixed_rules(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    """Check that a muscle's wraps use the same rule and do not cross the start of a branch."""
    if len({wrap.rule for wrap in muscle.wraps}) > 1:
        yield error(subject, "bad-wrap-rule", "its wraps use different rules; use only one")
    for wrap in muscle.wraps:
        if any(wrap.segment < branch.point <= wrap.last + 1 for branch in muscle.branches):
            problem = f"the wrap over {wrap.surface!r} crosses the start of a branch"
            yield error(subject, "bad-wrap-segment", problem)


def _coordinate(robot: Robot, subject: Subject, name: str, label: str) -> Iterator[Finding]:
    names = [c.name for c in robot.all_coordinates]
    if name not in names:
        problem = f"{label} depends on {unknown('coordinate', name, names)}"
        yield error(subject, "unknown-coordinate", problem)


def _pieces(muscle: Muscle) -> Iterator[tuple[int, int]]:
    """Yield the first and last via point of each piece of the path."""
    if not muscle.via_points:
        return
    starts = sorted({0, *(branch.point for branch in muscle.branches)})
    yield from zip(starts, [*(k - 1 for k in starts[1:]), len(muscle.via_points) - 1], strict=True)
