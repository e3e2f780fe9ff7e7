"""First motion that the muscles of a robot can perform: start pose, end pose, locked coordinates.

The start pose is the initial pose if the muscles can hold it, otherwise a pose nearby. Coordinates
that the muscles cannot drive there are locked. All other coordinates move at the same time, each in
the direction with the larger force margin, as far as all forces stay within their limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from addin_sdfusion.robot import InputError, Robot, limits
from addin_sdfusion.robot.transforms.lock import lock
from cardsflow_fmu.utils.arrays import FloatArray
from controllers import ApproachReference
from controllers.analysis.drivable import (
    ACCELERATION,
    MARGIN,
    DrivableCoordinates,
    Terms,
    find_drivable,
    force_margin,
)
from sim_dart import CoreDynamics, close_loops, control_dynamics
from sim_dart.core.mass_check import massless_coordinates

DURATION = 4.0
"""Duration of the motion to the end pose and back, in [s]."""
REACH = {"rad": 0.1, "m": 0.01}
"""Maximum motion of a coordinate, by unit."""

_MAX_SLIDE = 0.02  # maximum motion of a sliding coordinate, as fraction of the robot size
_LIMIT_DISTANCE = 0.05  # minimum distance of the start from joint limits, as fraction of the range
_UNLIMITED = 100.0  # assumed force limit of a muscle without f_max, in robot weights
_GRAVITY = 9.81  # in [m/s²], also for robots without gravity
_PATH = np.linspace(0.0, 1.0, 9)[1:]
_HALVINGS = 4
_MAX_POSES = 1000  # number of searched poses times the square of the number of coordinates

NO_RANGE, NO_MASS = "its joint limits leave no range", "it moves no mass (give its links masses)"
UNDRIVEN = "no muscle drives it"
DEPENDENT = "closed loops determine it"


@dataclass(frozen=True)
class FirstMotion:
    """Motion from a start pose to an end pose and back.

    Attributes:
        robot: The robot with locked coordinates.
        locked: Positions of locked coordinates, in [rad] or [m], by name.
        reasons: Reasons for the locks, by name.
        start, end: Positions of the other coordinates, in [rad] or [m].
        moved: Whether the start pose differs from the initial pose of the robot.
    """

    robot: Robot
    locked: Mapping[str, float]
    reasons: Mapping[str, str]
    start: tuple[float, ...]
    end: tuple[float, ...]
    moved: bool


def size_problem(robot: Robot) -> str | None:
    """Describe why the robot is too large for an analysis of its drives; None if it is not."""
    n, m = limits.DRIVEN_COORDINATES, limits.DRIVEN_MUSCLES
    if len(robot.coordinates) <= n and len(robot.muscles) <= m:
        return None
    return f"it has more than {n} coordinates or {m} muscles"


def first_motion(robot: Robot, scale: float = 1.0, undriven: Mapping[str, str] = {}) -> FirstMotion:
    """Find a motion that the muscles of a robot can perform.

    Args:
        robot: The robot, with at least one muscle and one coordinate.
        scale: Factor on the size of the motion.
        undriven: Other coordinates that must be locked, with the reason, by name.

    Returns:
        The motion. All coordinates are locked if the muscles cannot hold the robot.

    Raises:
        InputError: The robot is too large for the search.
    """
    if (large := size_problem(robot)) is not None:
        problem = f"robot {robot.name!r} is too large for the search of a first motion: {large}"
        raise InputError(f"{problem}; write experiment.toml by hand, see the examples")
    pose = initial_pose(robot)
    dynamics = control_dynamics(robot, may_be_singular=True)
    reasons = {c.name: NO_RANGE for c in robot.coordinates if not c.lower < c.upper}
    M = dynamics.mass_matrix([c.initial for c in robot.coordinates])
    reasons |= dict.fromkeys(massless_coordinates(robot, M), NO_MASS)
    reasons |= undriven
    pose = _closed_start(robot, dynamics, pose)
    for c, is_dependent in zip(robot.coordinates, dynamics.dependent, strict=True):
        if is_dependent:  # the closed loops determine them
            reasons.pop(c.name, None)
    drivable, q = _find_pose(robot, dynamics, pose, reasons)
    names = [c.name for c in robot.coordinates]
    reasons |= {names[k]: why for k, why in missing_drives(robot, dynamics, q, drivable).items()}
    for name in massless_coordinates(robot, dynamics.mass_matrix(q)):
        reasons.setdefault(name, NO_MASS)
    locked = {n: float(x) for n, x in zip(names, q, strict=True) if n in reasons}
    if set(reasons) >= {n for n, d in zip(names, dynamics.dependent, strict=True) if not d}:
        locked = {n: float(x) for n, x in zip(names, q, strict=True)}
        reasons |= {n: DEPENDENT for n in names if n not in reasons}
    reduced = lock(robot, locked)
    start = np.array([x for n, x in zip(names, q, strict=True) if n not in reasons])
    end = start
    if len(start):
        end = _end_pose(reduced, control_dynamics(reduced, may_be_singular=True), start, scale)
    return FirstMotion(
        reduced,
        locked,
        reasons,
        tuple(start.tolist()),
        tuple(end.tolist()),
        bool(np.abs(q - pose).max(initial=0.0) > 0.0),
    )


def pose_terms(robot: Robot, dynamics: CoreDynamics, q: FloatArray, qdd: FloatArray) -> Terms:
    """Return the required torques at a pose, and the torques that muscles and motors can produce.

    Args:
        q: The pose, shape (n,), in [rad] or [m].
        qdd: Accelerations, shape (n,), in [rad/s²] or [m/s²].
    """
    M, force = dynamics.mass_matrix(q), assumed_force(robot)
    arms = [robot_size(robot) if motor.unit == "rad" else 1.0 for motor in robot.motors]
    limit = force * np.append(np.ones(dynamics.m), arms)
    A = -dynamics.actuator_jacobian(q).T
    low, high = np.maximum(dynamics.f_min, -limit), np.minimum(dynamics.f_max, limit)
    with np.errstate(over="ignore", invalid="ignore"):
        torques, torque = A * (high - low), M @ qdd + dynamics.gravity(q)
    if not all(np.isfinite(array).all() for array in (M, torques, torque)):
        raise InputError(
            "inertias, moment arms, weights or forces are not finite; a length, mass or force of "
            "the robot is too large"
        )
    return Terms(
        M,
        A,
        torque,
        low,
        high,
        np.array([ACCELERATION[c.unit] for c in robot.coordinates]),
    )


def assumed_force(robot: Robot) -> float:
    """Return the force limit that is assumed for muscles without f_max, in [N]."""
    weight = sum(link.inertia.mass for link in robot.links) * _GRAVITY
    return max(_UNLIMITED * weight, *(10.0 * m.f_min for m in robot.muscles), 1e-9)


def initial_pose(robot: Robot) -> FloatArray:
    """Return the initial pose, moved away from the joint limits."""
    pose = []
    for c in robot.coordinates:
        joint_range = c.upper - c.lower
        distance = min(_LIMIT_DISTANCE * joint_range, REACH[c.unit]) if joint_range > 0.0 else 0.0
        low, high = c.lower + distance, c.upper - distance
        q = min(max(c.initial, c.lower), c.upper)
        pose.append(min(max(q, low), high))
    return np.array(pose)


def _find_pose(
    robot: Robot, dynamics: CoreDynamics, pose: FloatArray, reasons: Mapping[str, str]
) -> tuple[DrivableCoordinates, FloatArray]:
    """Find the pose at which the muscles drive most coordinates; nearby poses are preferred."""
    free = [
        k
        for k, c in enumerate(robot.coordinates)
        if c.name not in reasons and not dynamics.dependent[k]
    ]
    best, at = _drivable_at(robot, dynamics, pose, free), pose
    rng = np.random.default_rng(0)
    lower, upper = dynamics.q_min, dynamics.q_max
    spread = np.array([1.0 if c.unit == "rad" else 20.0 * _slide(robot) for c in robot.coordinates])
    spread = np.minimum(spread, np.where(np.isfinite(upper - lower), 0.4 * (upper - lower), np.inf))
    count = min(200, _MAX_POSES // max(1, len(free)) ** 2) if len(free) else 0
    for k in range(count):
        if len(best.coordinates) == len(free):
            break
        away = rng.uniform(-1.0, 1.0, len(pose)) * spread * (k + 1) / count
        q = pose.copy()
        q[free] = np.clip(pose + away, lower, upper)[free]
        if dynamics.dependent.any():
            q = try_close_loops(dynamics, q, pose)
        drivable = _drivable_at(robot, dynamics, q, free)
        if len(drivable.coordinates) > len(best.coordinates):
            best, at = drivable, q
    return best, at


def try_close_loops(
    dynamics: CoreDynamics, q: FloatArray, fallback: FloatArray | None = None
) -> FloatArray:
    """Close the loops of a pose; return the fallback (default: the pose) if that fails."""
    try:
        return dynamics.closed(q)
    except InputError:
        return q if fallback is None else fallback


def _closed_start(robot: Robot, dynamics: CoreDynamics, pose: FloatArray) -> FloatArray:
    """Close the loops of a pose within the joint limits; move independent coordinates if needed."""
    q = try_close_loops(dynamics, pose)
    lower = np.array([c.lower for c in robot.coordinates])
    upper = np.array([c.upper for c in robot.coordinates])
    if (q >= lower).all() and (q <= upper).all() and (q is not pose or not robot.loops):
        return q
    try:
        return close_loops(robot, pose)
    except InputError:
        return q


def _drivable_at(
    robot: Robot, dynamics: CoreDynamics, q: FloatArray, free: list[int]
) -> DrivableCoordinates:
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    massless = massless_coordinates(robot, terms.M)
    return find_drivable(terms, [k for k in free if robot.coordinates[k].name not in massless])


def robot_size(robot: Robot) -> float:
    """Estimate the size of the robot, in [m]."""
    points = [p.position for m in robot.muscles for p in m.via_points]
    size = float(np.ptp(np.array(points), axis=0).max()) if points else 0.0
    offsets = [abs(x) for j in robot.joints for x in j.T_parent_joint.position]
    return max([size, *offsets]) or 1.0


def _slide(robot: Robot) -> float:
    """Return the maximum motion of a sliding coordinate, in [m]."""
    return min(REACH["m"], _MAX_SLIDE * robot_size(robot))


def _end_pose(robot: Robot, dynamics: CoreDynamics, start: FloatArray, scale: float) -> FloatArray:
    """Return the end pose: as far from the start as all forces stay within their limits."""
    slide = _slide(robot)
    step = np.zeros(len(start))
    for k, c in enumerate(robot.coordinates):
        if not dynamics.dependent[k]:
            max_step = scale * (REACH["rad"] if c.unit == "rad" else slide)
            options = (
                -min(max_step, 0.5 * (start[k] - c.lower)),
                min(max_step, 0.5 * (c.upper - start[k])),
            )
            step[k] = _signed_step(robot, dynamics, start, k, options)
    for _ in range(_HALVINGS):
        if _margin_along(robot, dynamics, start, step, _PATH) > MARGIN:
            break
        step *= 0.5
    return try_close_loops(dynamics, start + step, start)


def _signed_step(
    robot: Robot, dynamics: CoreDynamics, start: FloatArray, k: int, options: tuple[float, float]
) -> float:
    """Return the step of one coordinate with the larger force margin, halved until one fits."""
    for fraction in 0.5 ** np.arange(_HALVINGS):
        steps = [_unit_step(k, fraction * option, start) for option in options]
        margins = [_margin_along(robot, dynamics, start, step) for step in steps]
        gains = [max(t - MARGIN, 0.0) * abs(x) for t, x in zip(margins, options, strict=True)]
        if max(gains) > 0.0:
            return float(fraction * options[int(np.argmax(gains))])
    return 0.0


def _unit_step(k: int, size: float, like: FloatArray) -> FloatArray:
    step = np.zeros_like(like)
    step[k] = size
    return step


def _margin_along(
    robot: Robot,
    dynamics: CoreDynamics,
    start: FloatArray,
    step: FloatArray,
    path: FloatArray = np.ones(1),  # noqa: B008
) -> float:
    """Return the smallest force margin along a quintic motion, at given fractions of its time."""
    rows, T = np.flatnonzero(~dynamics.dependent).tolist(), 0.5 * DURATION
    motion = ApproachReference(start, start + step, T).evaluate(T * path)
    margins = []
    for desired, qdd in zip(motion.q, motion.qdd, strict=True):
        try:
            q = dynamics.closed(desired)
        except InputError:
            return -np.inf
        margins.append(force_margin(pose_terms(robot, dynamics, q, qdd), rows)[0])
    return min(margins)


def missing_drives(
    robot: Robot, dynamics: CoreDynamics, q: FloatArray, drivable: DrivableCoordinates
) -> dict[int, str]:
    """Return, by index, the reasons why coordinates are not sufficiently driven at a pose."""
    if not drivable.missing:
        return {}
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    limit = np.full(dynamics.m, assumed_force(robot))
    high = np.append(np.maximum(terms.high[: dynamics.m], limit), terms.high[dynamics.m :])
    strong = replace(terms, high=high)
    driven = find_drivable(strong, sorted([*drivable.coordinates, *drivable.missing])).coordinates
    reasons = {}
    for k, missing in drivable.missing.items():
        name = robot.coordinates[k].name
        if k in driven:
            reasons[k] = "its drives are too weak; `cardsflow size` computes the required forces"
        elif missing == "any muscle":
            reasons[k] = UNDRIVEN
        elif missing == "independent motion":
            reasons[k] = "muscles cannot move it independently of the others"
        else:
            others = " while they hold the other joints" if drivable.coordinates else ""
            sign = "negative" if missing == "down" else "positive"
            reasons[k] = f"no muscle produces {sign} torque at {name}{others}"
    return reasons
