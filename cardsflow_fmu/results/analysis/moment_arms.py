"""Findings on muscles whose moment arm changes its sign within the range of a hinge."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from addin_sdfusion.robot import Coordinate, Finding, Joint, Robot, Subject
from addin_sdfusion.robot.finding_builders import warning
from addin_sdfusion.robot.model.link_poses import initial_poses
from addin_sdfusion.robot.model.rotations import compose
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import CoreDynamics

from .first_motion import robot_size

SIGN_CHANGE = "moment-arm-changes-sign"

_SAMPLES = 16  # positions of a hinge
_RELEVANT = 0.3  # moment arm, as fraction of the largest one at the hinge
_HALF_TURN = math.pi  # range of a hinge within which a straight cable can keep its sign
_SAME_PLACE = 0.01  # distance of hinges that form a ball joint, as fraction of the robot size


def sign_changes(robot: Robot, dynamics: CoreDynamics, pose: FloatArray) -> Iterator[Finding]:
    """Report muscles whose moment arm about a hinge changes its sign within the joint limits.

    This usually is a wrap on the wrong side, or a via point that passes the axis. Small moment arms
    are ignored, and so are joints where sign changes are normal: joints with several coordinates or
    several hinges at the same place, hinges with a range of half a turn or more (there the
    moment arm of each straight cable changes its sign), and robots with closed loops.

    Args:
        robot: A robot without errors.
        pose: Positions of the other coordinates, shape (n,), in [rad] or [m].
    """
    if not robot.muscles or dynamics.dependent.any():
        return
    for k in _hinges(robot):
        c, at = robot.coordinates[k], _moment_arms(dynamics, pose, k)
        positions = np.linspace(c.lower, c.upper, _SAMPLES)
        arms = np.array([at(q) for q in positions])
        low, high = arms.min(axis=0), arms.max(axis=0)
        relevant = _RELEVANT * np.abs(arms).max(initial=0.0)
        for m in np.flatnonzero(np.minimum(-low, high) > relevant).tolist():
            muscle = robot.muscles[m]
            q = _find_change(at, positions, arms[:, m], m)
            cause = "the side of its wraps" if muscle.wraps else "its via points"
            problem = (
                f"its moment arm about coordinate {c.name!r} changes sign at {q:.3g} rad (it is "
                f"{low[m]:.2g} to {high[m]:.2g} m within the joint limits); check {cause}"
            )
            yield warning(Subject("muscle", muscle.name), SIGN_CHANGE, problem)


def _moment_arms(dynamics: CoreDynamics, pose: FloatArray, k: int) -> Callable[[float], FloatArray]:
    """Return the function from a position of coordinate k to all moment arms, shape (m,)."""

    def at(q: float) -> FloatArray:
        moved = pose.copy()
        moved[k] = q
        return -dynamics.muscle_jacobian(moved)[:, k]

    return at


def _find_change(
    at: Callable[[float], FloatArray], positions: FloatArray, arms: FloatArray, muscle: int
) -> float:
    """Return the first position at which the moment arm of a muscle changes its sign."""
    from scipy.optimize import brentq  # slow to import

    first = int(np.flatnonzero(np.diff(arms > 0.0))[0])
    return float(brentq(lambda q: at(q)[muscle], *positions[first : first + 2]))


@np.errstate(over="ignore", invalid="ignore")  # of a robot with huge lengths
def _hinges(robot: Robot) -> list[int]:
    """Return the indices of coordinates that turn a hinge by less than half a turn."""
    poses, distance = initial_poses(robot), _SAME_PLACE * robot_size(robot)
    moving = [joint for joint in robot.joints if any(c.is_free for c in joint.coordinates)]
    places = {j.name: compose(poses[j.parent], j.T_parent_joint).position for j in moving}
    joints = {c.name: joint for joint in moving for c in joint.coordinates}

    def is_part_of_ball(joint: Joint) -> bool:
        return any(
            (other.child == joint.parent or other.parent == joint.child)
            and math.dist(places[other.name], places[joint.name]) < distance
            for other in moving
        )

    def is_hinge(c: Coordinate) -> bool:
        joint, is_partial = joints[c.name], 0.0 < c.upper - c.lower < _HALF_TURN
        is_single = c.unit == "rad" and len(joint.coordinates) == 1
        return is_single and is_partial and not is_part_of_ball(joint)

    return [k for k, c in enumerate(robot.coordinates) if is_hinge(c)]
