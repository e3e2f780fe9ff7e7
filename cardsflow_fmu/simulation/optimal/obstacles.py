"""Obstacles for end-effector points, links and cables of a motion."""

from __future__ import annotations

from collections.abc import Sequence
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
from controllers.optimal.problem import NodeConstraint, excess
from sim_dart.dynamics.core import CoreDynamics

from .segments import Segment, SegmentDistances

_PASSAGE = 1e-4  # violation between nodes that is reported, in m


def obstacle_constraints(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, nodes: IntArray, nx: int
) -> tuple[list[NodeConstraint], tuple[str, ...]]:
    """Return a constraint for each obstacle, at some nodes, and notes about its parts.

    Raises:
        InputError: A part does not exist or is not supported, or starts inside an obstacle.
    """
    found, notes = list[NodeConstraint](), dict[str, None]()
    x = np.zeros((1, nx))
    x[0, : dynamics.n] = experiment.start.q
    for k, own in enumerate(motion.obstacles):
        key = f"motion.obstacles[{k}]"
        try:
            segments = _segments(dynamics.robot, own)
        except InputError as error:
            error.file, error.key = experiment.file, f"{key}.{error.key}"
            raise
        notes |= dict.fromkeys(_neglected_wraps(dynamics.robot, own))
        axis = np.array([own.centre, own.end or own.centre])
        distances = SegmentDistances(dynamics.robot, segments, axis, nx)
        names, least = tuple(each.name for each in segments), own.radius + own.clearance
        start = distances(x)[0][0]
        if nodes[0] and start.min() < least:
            from_what = "centre" if own.end is None else "axis"
            what = f"contains {names[start.argmin()]} at the start, {start.min():.4g} m from its"
            what = f"{what} {from_what}"
            raise InputError(what, file=experiment.file, key=key)
        low, high = np.full(len(names), least), np.full(len(names), np.inf)
        name = key.partition(".")[2]
        found.append(NodeConstraint(name, names, nodes, distances, low, high))
    return found, tuple(notes)


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
    for own in constraints:
        if len(own.nodes) == 1:
            continue
        miss = excess(own.evaluate(x)[0], own.low, own.high)
        k, row = np.unravel_index(int(miss.argmax()), miss.shape)
        if miss[k, row] > _PASSAGE:
            what = f"the motion violates {own.name}.{own.rows[row]} by up to {miss[k, row]:.3g}"
            hint = "increase motion.intervals" + " or clearance" * own.name.startswith("obstacles")
            lines.append(f"{what} between nodes, at t = {times[k]:.4g} s; {hint}")
    return tuple(lines)


def _segments(robot: Robot, own: ObstacleSettings) -> list[Segment]:
    """Return the segments of the parts of a robot for an obstacle.

    Raises:
        InputError: A part does not exist or is not supported; its key is relative to the obstacle.
    """
    points = {frame.name: frame for frame in robot.task_frames if not frame.is_orientation}
    names = own.points or (() if own.links or own.cables else tuple(points))
    found = []
    for name in _chosen("end-effector point", "points", names, list(points)):
        frame = points[name]
        place = frame.link, frame.position
        found.append(Segment(name, place, place, "".join(frame.axes)))
    along = {link.name: _along(robot, link.name) for link in robot.links}
    moving = [name for name, segments in along.items() if segments]
    for name in _chosen("link with a length", "links", own.links, moving):
        found += along[name]
    paths = {muscle.name: muscle for muscle in robot.muscles if len(muscle.via_points) > 1}
    for name in _chosen("muscle with via points", "cables", own.cables, list(paths)):
        via = paths[name].via_points
        if any(point.moves or point.when is not None for point in via):
            what = f"{name!r} has moving or conditional points, which are not supported"
            raise InputError(what, key="cables")
        places = [(point.link, point.position) for point in via]
        found += [Segment(name, *pair) for pair in pairwise(places)]
    if not found:
        what = "has no parts that avoid it; set points, links or cables"
        raise InputError(what, key="points")
    return found


def _along(robot: Robot, name: str) -> list[Segment]:
    """Return the segments of a link from its joint to child joints, its end and task frames."""
    link = robot.link(name)
    pairs = link_segments(robot, link)
    begin = [j.T_child_joint.position for j in robot.joints if j.child == name]
    frames = [frame.position for frame in robot.task_frames if frame.link == name]
    ends = {end for _, end in pairs} | set(begin)
    pairs += [(begin[0], position) for position in frames if begin and position not in ends]
    return [Segment(name, (name, start), (name, end)) for start, end in dict.fromkeys(pairs)]


def _chosen(kind: str, key: str, names: Sequence[str], known: list[str]) -> list[str]:
    """Return the chosen names, all for `*`."""
    for name in names:
        if name not in (*known, EVERY_OTHER):
            raise UnknownNameError(kind, name, known, key=key)
    return known if EVERY_OTHER in names else list(dict.fromkeys(names))


def _neglected_wraps(robot: Robot, own: ObstacleSettings) -> list[str]:
    """Return notes about muscles with wraps, whose segments are not straight."""
    wrapped = [
        muscle.name
        for muscle in robot.muscles
        if muscle.wraps and {muscle.name, EVERY_OTHER} & set(own.cables)
    ]
    what = "obstacles neglect wrap surfaces between the via points of"
    return [f"{what} {', '.join(wrapped)}"] if wrapped else []
