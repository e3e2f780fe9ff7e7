"""Obstacles for end-effector points, links and cables of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.model.link_segments import link_segments
from cardsflow_fmu.experiment.config.key_path import EVERY_OTHER
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.bounds import ObstacleSettings
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.arrays import IntArray
from controllers.optimal.problem import Iterate, NodeConstraint, OptimalProblem, excess
from sim_dart.dynamics.core import CoreDynamics

from .segments import Segment, SegmentDistances

_PASSAGE = 1e-4  # violation between nodes that is reported, in m or rad
_INSIDE = 1e-6  # violation between nodes that is corrected, in m or rad
_MIN_SHARES, _MAX_SHARES = 8, 256  # checked points of an interval
_MAX_SPACED = 4  # parts of an interval with equal lengths
_NEAR = 0.5  # distance of a blocked motion, relative to the required one
_SAME = 0.01  # distance of points of an interval that are equal, relative to the interval


def obstacle_constraints(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, nodes: IntArray, nx: int
) -> tuple[list[NodeConstraint], tuple[str, ...]]:
    """Return a constraint for each obstacle, at some nodes, and notes about its parts.

    Raises:
        InputError: A part does not exist or is not supported, or starts inside an obstacle.
    """
    constraints, notes = list[NodeConstraint](), dict[str, None]()
    x = np.zeros((1, nx))
    x[0, : dynamics.n] = experiment.start.q
    for k, obstacle in enumerate(motion.obstacles):
        key = f"motion.obstacles[{k}]"
        try:
            segments = _segments(dynamics.robot, obstacle)
        except InputError as error:
            error.file, error.key = experiment.file, f"{key}.{error.key}"
            raise
        notes |= dict.fromkeys(_neglected_wraps(dynamics.robot, obstacle))
        axis = np.array([obstacle.centre, obstacle.end or obstacle.centre])
        distances = SegmentDistances(dynamics.robot, segments, axis, nx)
        names, least = tuple(each.name for each in segments), obstacle.radius + obstacle.clearance
        start = distances(x)[0][0]
        if nodes[0] and start.min() < least:
            origin = "centre" if obstacle.end is None else "axis"
            problem = (
                f"contains {names[start.argmin()]!r} at the start, {start.min():.4g} m from its"
            )
            problem = f"{problem} {origin}"
            raise InputError(problem, file=experiment.file, key=key)
        low, high = np.full(len(names), least), np.full(len(names), np.inf)
        name = key.partition(".")[2]
        constraints.append(NodeConstraint(name, names, nodes, distances, low, high))
    return constraints, tuple(notes)


def passages(
    constraints: Sequence[NodeConstraint], times: FloatArray, x: FloatArray
) -> tuple[str, ...]:
    """Return a line for each path constraint that a motion violates between the nodes.

    Args:
        constraints: Constraints; those of single nodes are goals.
        times: Times of the samples, shape (k,), in [s].
        x: States, shape (k, nx).
    """
    lines = []
    for path in constraints:
        if len(path.nodes) == 1 or path.shares is not None:
            continue
        miss = excess(path.evaluate(x)[0], path.low, path.high)
        k, row = np.unravel_index(int(miss.argmax()), miss.shape)
        if miss[k, row] > _PASSAGE:
            text = f"the motion violates {path.name}.{path.rows[row]} by up to {miss[k, row]:.3g}"
            hint = "increase motion.intervals" + " or clearance" * path.name.startswith("obstacles")
            lines.append(f"{text} between nodes, at t = {times[k]:.4g} s; {hint}")
    return tuple(lines)


def between_nodes(problem: OptimalProblem, at: Iterate, step: float) -> tuple[NodeConstraint, ...]:
    """Return constraints at points between the nodes, where a motion violates path constraints.

    In each interval, these are the points of the largest violations.

    Args:
        problem: The problem.
        at: A motion.
        step: Distance of the checked points in time, in [s].
    """
    N, constraints = problem.intervals, list[NodeConstraint]()
    count = int(np.clip(np.ceil(at.duration / N / step), _MIN_SHARES, _MAX_SHARES))
    paths = [path for path in problem.constraints if len(path.nodes) > 1 and path.shares is None]
    x = inner_states(problem, at, count) if paths else None
    if x is None:
        return ()
    for path in paths:
        low = np.where(path.low < path.high, path.low, -np.inf)  # equalities hold at nodes only
        high = np.where(path.low < path.high, path.high, np.inf)
        g = path.evaluate(x)[0].reshape(N, count + 1, -1)
        miss = np.maximum(low - g, g - high)
        places = {place for k in range(N) for place in _peaks(k, miss[k])}
        if places:
            inside = np.array(sorted(places)).T
            constraints.append(
                replace(path, nodes=inside[0].astype(int), low=low, high=high, shares=inside[1])
            )
    return tuple(constraints)


def inner_states(problem: OptimalProblem, at: Iterate, count: int) -> FloatArray | None:
    """Return the states at equal distances in each interval, with both ends; None if one diverged.

    Returns:
        Shape (N (count + 1), nx).
    """
    N = problem.intervals
    nodes, shares = np.repeat(np.arange(N), count + 1), np.tile(np.linspace(0.0, 1.0, count + 1), N)
    parts = problem.run_inside(at, nodes, shares, derivatives=False)
    return None if parts is None else parts.ends


def against_jumps(problem: OptimalProblem, at: Iterate) -> tuple[NodeConstraint, ...]:
    """Return constraints at equal distances in the intervals, if these are too long for nodes only.

    Between two constrained points, a segment moves at most as far as it must be away from the axis
    of an obstacle, so that it does not jump over it.

    Args:
        problem: The problem.
        at: The motion without obstacles.
    """
    N, constraints = problem.intervals, list[NodeConstraint]()
    for constraint in problem.constraints:
        if isinstance(constraint.evaluate, SegmentDistances):
            gaps, _ = constraint.evaluate.nearest(at.x[:, : constraint.evaluate.n])
            steps = np.linalg.norm(np.diff(gaps, axis=0), axis=2) / constraint.low
            count = min(int(np.ceil(steps.max())), _MAX_SPACED)
            if count > 1:
                shares = np.tile(np.arange(1, count) / count, N)
                nodes = np.repeat(np.arange(N), count - 1)
                constraints.append(replace(constraint, nodes=nodes, shares=shares))
    return tuple(constraints)


def is_blocked(problem: OptimalProblem, at: Iterate) -> bool:
    """Return whether a motion passes through an obstacle, below half the required distance."""
    obstacles = [c for c in problem.constraints if isinstance(c.evaluate, SegmentDistances)]
    x = inner_states(problem, at, _MIN_SHARES) if obstacles else None
    return x is not None and any((c.evaluate(x)[0] < _NEAR * c.low).any() for c in obstacles)


def _peaks(node: int, miss: FloatArray) -> list[tuple[int, float]]:
    """Return a node and the share of its interval at the peak of each row's violation.

    Args:
        node: The node.
        miss: Violations at equal distances in the interval, shape (k + 1, rows).
    """
    peaks = list[tuple[int, float]]()
    count, best = len(miss) - 1, miss.argmax(axis=0)
    for row, j in enumerate(best.tolist()):
        if miss[j, row] <= _INSIDE or j in (0, count):
            continue
        before, here, after = miss[j - 1 : j + 2, row].tolist()
        bend = before - 2.0 * here + after
        share = (j + (0.5 * (before - after) / bend if bend < 0.0 else 0.0)) / count
        if all(abs(share - other) > _SAME for _, other in peaks):
            peaks.append((node, share))
    return peaks


def _segments(robot: Robot, obstacle: ObstacleSettings) -> list[Segment]:
    """Return the segments of the parts of a robot for an obstacle.

    Raises:
        InputError: A part does not exist or is not supported; its key is relative to the obstacle.
    """
    points = {frame.name: frame for frame in robot.task_frames if not frame.is_orientation}
    names = obstacle.points or (() if obstacle.links or obstacle.cables else tuple(points))
    chosen = []
    for name in _chosen("end-effector point", "points", names, list(points)):
        frame = points[name]
        place = frame.link, frame.position
        chosen.append(Segment(name, place, place, "".join(frame.axes)))
    along = {link.name: _along(robot, link.name) for link in robot.links}
    moving = [name for name, segments in along.items() if segments]
    for name in _chosen("link with a length", "links", obstacle.links, moving):
        chosen += along[name]
    paths = {muscle.name: muscle for muscle in robot.muscles if len(muscle.via_points) > 1}
    for name in _chosen("muscle with via points", "cables", obstacle.cables, list(paths)):
        via = paths[name].via_points
        if any(point.moves or point.when is not None for point in via):
            problem = f"{name!r} has moving or conditional points, which are not supported"
            raise InputError(problem, key="cables")
        places = [(point.link, point.position) for point in via]
        chosen += [Segment(name, *pair) for pair in pairwise(places)]
    if not chosen:
        problem = "has no parts that avoid it; set points, links or cables"
        raise InputError(problem, key="points")
    return chosen


def _along(robot: Robot, name: str) -> list[Segment]:
    """Return the segments of a link from its joint to child joints, its end and task frames."""
    link = robot.link(name)
    pairs = link_segments(robot, link)
    begin = [j.T_child_joint.position for j in robot.joints if j.child == name]
    frames = [frame.position for frame in robot.task_frames if frame.link == name]
    ends = {end for _, end in pairs} | set(begin)
    pairs += [(begin[0], position) for position in frames if begin and position not in ends]
    return [Segment(name, (name, start), (name, end)) for start, end in dict.fromkeys(pairs)]


def _chosen(kind: str, key: str, names: Sequence[str], all_names: list[str]) -> list[str]:
    """Return the chosen names, all for `*`."""
    for name in names:
        if name not in (*all_names, EVERY_OTHER):
            raise UnknownNameError(kind, name, all_names, key=key)
    return all_names if EVERY_OTHER in names else list(dict.fromkeys(names))


def _neglected_wraps(robot: Robot, obstacle: ObstacleSettings) -> list[str]:
    """Return notes about muscles with wraps, whose segments are not straight."""
    wrapped = [
        muscle.name
        for muscle in robot.muscles
        if muscle.wraps and {muscle.name, EVERY_OTHER} & set(obstacle.cables)
    ]
    note = "obstacles neglect wrap surfaces between the via points of"
    return [f"{note} {', '.join(wrapped)}"] if wrapped else []
