"""Checks of what muscle paths have beside fixed points: conditions, branches, terms, wrap rules."""

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
    """Via points are in use within a range of a coordinate that exists."""
    for subject, muscle in all_muscles(robot):
        for k, point in enumerate(muscle.via_points):
            if point.when is None:
                continue
            yield from _coordinate(robot, subject, point.when.coordinate, f"via point {k + 1}")
            if point.when.low > point.when.high or point.when.smoothing < 0.0:
                problem = f"via point {k + 1} is in use from {point.when.low!r} to "
                problem += f"{point.when.high!r}, smoothed over {point.when.smoothing!r}: no range"
                yield error(subject, "bad-point-condition", problem)


def moving_points(robot: Robot) -> Iterator[Finding]:
    """Via points move by functions of coordinates that exist."""
    for subject, muscle in all_muscles(robot):
        for k, point in enumerate(muscle.via_points, start=1):
            for move in point.moves:
                yield from _coordinate(robot, subject, move.coordinate, f"via point {k}")
                fault = function_fault(move.function)
                if fault:
                    yield error(subject, "bad-function", f"via point {k}: its {fault}")
                if not move.low <= move.high or not finite(move.axis):
                    problem = f"via point {k} moves from {move.low!r} to {move.high!r} along "
                    yield error(subject, "bad-point-motion", problem + f"{move.axis!r}: no range")


def branches(robot: Robot) -> Iterator[Finding]:
    """Branches follow each other, have two via points at least and a divisor."""
    for subject, muscle in all_muscles(robot):
        starts, points = [branch.point for branch in muscle.branches], len(muscle.via_points)
        if starts != sorted(set(starts)) or not all(0 <= k < points for k in starts):
            problem = f"branches start at via points {starts}, which must exist and increase"
            yield error(subject, "bad-branch", problem)
        elif starts and any(last <= first for first, last in _pieces(muscle)):
            yield error(subject, "bad-branch", "a branch needs at least two via points")
        if any(branch.divisor == 0.0 for branch in muscle.branches):
            yield error(subject, "bad-branch", "a branch's divisor is 0")


def terms(robot: Robot) -> Iterator[Finding]:
    """Terms are proportional to coordinates that exist."""
    for subject, muscle in all_muscles(robot):
        for term in muscle.terms:
            yield from _coordinate(robot, subject, term.coordinate, "term")


def wrap_rules(robot: Robot) -> Iterator[Finding]:
    """Wraps have what their rule knows, and nothing else."""
    shapes = {surface.name: surface.shape for surface in robot.wrap_surfaces}
    links = [WORLD, *(link.name for link in robot.links)]
    for subject, muscle in all_muscles(robot):
        for wrap in muscle.wraps:
            for problem in _rule_problems(wrap, shapes.get(wrap.surface, "")):
                yield error(subject, "bad-wrap-rule", f"wrap over {wrap.surface!r}: {problem}")
            if wrap.side_point is not None and wrap.side_point.link not in links:
                problem = f"side point on {unknown('link', wrap.side_point.link, links)}"
                yield error(subject, "unknown-wrap-link", problem)
        yield from _one_a_segment(subject, muscle)
        yield from _mixed(subject, muscle)


def _rule_problems(wrap: Wrap, shape: str) -> Iterator[str]:
    if wrap.rule not in get_args(WrapRule) or wrap.quadrant not in get_args(Quadrant):
        yield f"rule {wrap.rule!r} or quadrant {wrap.quadrant!r} is not known"
        return
    if wrap.rule != "taut" and (wrap.side or wrap.turns or wrap.inside):
        yield f"by the rule {wrap.rule!r} it has no side, no turns and is not inside; remove them"
    if wrap.rule != "mujoco" and wrap.side_point is not None:
        yield "only by the rule 'mujoco' it has a side point"
    if wrap.rule != "opensim" and (wrap.quadrant != "all" or wrap.last_segment is not None):
        yield "only by the rule 'opensim' it has a quadrant or several segments"
    if wrap.rule == "mujoco" and shape == "ellipsoid":
        yield "MuJoCo's rules know no ellipsoids"
    if shape == "ellipsoid" and (wrap.side or wrap.turns or wrap.inside):
        yield "over an ellipsoid it has no side, no turns and is not inside; remove them"


def _one_a_segment(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    counts = Counter(wrap.segment for wrap in muscle.wraps if wrap.rule == "mujoco")
    for segment, count in counts.items():
        if count > 1:
            problem = f"{count} wraps by the rule 'mujoco' in segment {segment}; it is one at most"
            yield error(subject, "bad-wrap-rule", problem)


def _mixed(subject: Subject, muscle: Muscle) -> Iterator[Finding]:
    """Wraps of one muscle by the same rule; across the beginning of a branch there is none."""
    if len({wrap.rule for wrap in muscle.wraps}) > 1:
        yield error(subject, "bad-wrap-rule", "its wraps go by different rules; keep one")
    for wrap in muscle.wraps:
        if any(wrap.segment < branch.point <= wrap.last + 1 for branch in muscle.branches):
            problem = f"wrap over {wrap.surface!r} reaches over the beginning of a branch"
            yield error(subject, "bad-wrap-segment", problem)


def _coordinate(robot: Robot, subject: Subject, name: str, what: str) -> Iterator[Finding]:
    known = [c.name for c in robot.all_coordinates]
    if name not in known:
        problem = f"{what} depends on {unknown('coordinate', name, known)}"
        yield error(subject, "unknown-coordinate", problem)


def _pieces(muscle: Muscle) -> Iterator[tuple[int, int]]:
    """First and last via point of each piece of the path."""
    if not muscle.via_points:
        return
    starts = sorted({0, *(branch.point for branch in muscle.branches)})
    yield from zip(starts, [*(k - 1 for k in starts[1:]), len(muscle.via_points) - 1], strict=True)
