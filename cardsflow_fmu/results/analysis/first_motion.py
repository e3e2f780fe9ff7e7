"""A first motion that a robot's muscles can make: where it starts, what moves, what is locked.

The start is the initial pose where muscles can hold it, else one nearby; coordinates that muscles
cannot drive there are locked. Each of the others then moves where the forces have more room, all
at once, by as much as keeps the forces within their bounds all along.
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
    Drivable,
    Terms,
    drivable,
    force_margin,
)
from sim_dart import CoreDynamics, control_dynamics
from sim_dart.core.mass_check import massless_coordinates

DURATION = 4.0
"""In [s]: half of it there, half of it back."""
REACH = {"rad": 0.1, "m": 0.01}
"""How far a coordinate goes where limits and muscles leave room."""

_OF_REACH = 0.02  # of the robot's size, the most that a sliding coordinate goes
_FROM_LIMITS = 0.05  # of the range between its limits, the least distance of a start from them
_UNLIMITED = 100.0  # times the robot's weight: what a muscle without a limit is counted on for
_GRAVITY = 9.81  # where the robot has none, in [m/s²]
_PATH = np.linspace(0.0, 1.0, 9)[1:]
_HALVINGS = 4
_SEARCHED = 1000  # poses that are tried, over the square of the number of coordinates

NO_ROOM, NO_MASS = "its limits leave it no room", "it moves no mass"
UNDRIVEN = "no muscle moves it"
FOLLOWS = "loops make it follow from the others"


@dataclass(frozen=True)
class FirstMotion:
    """A motion there and back.

    Attributes:
        robot: The robot, with what is locked.
        locked: What coordinates are locked at, in [rad] or [m], by name.
        reasons: Why, by name, in words.
        start, end: Positions of the coordinates that are left, in [rad] or [m].
        moved: Whether the start is another pose than the robot's own.
    """

    robot: Robot
    locked: Mapping[str, float]
    reasons: Mapping[str, str]
    start: tuple[float, ...]
    end: tuple[float, ...]
    moved: bool


def very_large(robot: Robot) -> str | None:
    """What makes a robot so large that looking at its drives takes minutes; None where nothing."""
    n, m = limits.DRIVEN_COORDINATES, limits.DRIVEN_MUSCLES
    if len(robot.coordinates) <= n and len(robot.muscles) <= m:
        return None
    return f"it has more than {n} coordinates or {m} muscles"


def first_motion(robot: Robot, scale: float = 1.0, held: Mapping[str, str] = {}) -> FirstMotion:
    """A motion that the muscles of a robot can make.

    Args:
        robot: The robot, with a muscle and a coordinate at least.
        scale: Factor on how far coordinates go.
        held: Coordinates that are locked in any case, and why.

    Returns:
        The motion; no coordinate is left where the robot cannot be held at all.

    Raises:
        InputError: The robot is too large to look for one.
    """
    if (large := very_large(robot)) is not None:
        what = f"robot {robot.name!r}: no motion is looked for, as {large}"
        raise InputError(f"{what}: write experiment.toml by hand, as those of the examples")
    pose = initial_pose(robot)
    dynamics = control_dynamics(robot, may_be_singular=True)
    reasons = {c.name: NO_ROOM for c in robot.coordinates if not c.lower < c.upper}
    reasons |= dict.fromkeys(massless_coordinates(robot, _initial_mass(robot, dynamics)), NO_MASS)
    reasons |= held
    pose = closed_or(dynamics, pose)
    for c, follows in zip(robot.coordinates, dynamics.dependent, strict=True):
        if follows:  # they go where the loops are closed
            reasons.pop(c.name, None)
    found, q = _held_pose(robot, dynamics, pose, reasons)
    names = [c.name for c in robot.coordinates]
    reasons |= {names[k]: why for k, why in lacks(robot, dynamics, q, found).items()}
    for name in massless_coordinates(robot, dynamics.mass_matrix(q)):
        reasons.setdefault(name, NO_MASS)
    locked = {n: float(x) for n, x in zip(names, q, strict=True) if n in reasons}
    if set(reasons) >= {n for n, d in zip(names, dynamics.dependent, strict=True) if not d}:
        locked = {n: float(x) for n, x in zip(names, q, strict=True)}  # nothing moves by itself
        reasons |= {n: FOLLOWS for n in names if n not in reasons}
    left = lock(robot, locked)
    start = np.array([x for n, x in zip(names, q, strict=True) if n not in reasons])
    end = start
    if len(start):
        end = _end(left, control_dynamics(left, may_be_singular=True), start, scale)
    return FirstMotion(
        left,
        locked,
        reasons,
        tuple(start.tolist()),
        tuple(end.tolist()),
        bool(np.abs(q - pose).max(initial=0.0) > 0.0),
    )


def pose_terms(robot: Robot, dynamics: CoreDynamics, q: FloatArray, qdd: FloatArray) -> Terms:
    """What the muscles and motors of a robot have to hold at a pose, and what they have for it.

    Args:
        robot: The robot.
        dynamics: Its dynamics.
        q: The pose, shape (n,), in [rad] or [m].
        qdd: Accelerations, shape (n,), in [rad/s²] or [m/s²].

    Raises:
        InputError: Some of it is beyond the range of numbers.
    """
    M, force = dynamics.mass_matrix(q), counted_force(robot)
    arms = [robot_size(robot) if motor.unit == "rad" else 1.0 for motor in robot.motors]
    counted = force * np.append(np.ones(dynamics.m), arms)
    A, torque = -dynamics.actuator_jacobian(q).T, M @ qdd + dynamics.gravity(q)
    low, high = np.maximum(dynamics.f_min, -counted), np.minimum(dynamics.f_max, counted)
    with np.errstate(over="ignore", invalid="ignore"):
        torques = A * (high - low)
    if not all(np.isfinite(part).all() for part in (M, torques, torque)):
        raise InputError(
            "inertias, moment arms, weights or forces are beyond the range of numbers; a length, a "
            "mass or a force is far too large"
        )
    return Terms(
        M,
        A,
        torque,
        low,
        high,
        np.array([ACCELERATION[c.unit] for c in robot.coordinates]),
    )


def counted_force(robot: Robot) -> float:
    """What a muscle without a limit is counted on for, in [N]."""
    weight = sum(link.inertia.mass for link in robot.links) * _GRAVITY
    return max(_UNLIMITED * weight, *(10.0 * m.f_min for m in robot.muscles), 1e-9)


def initial_pose(robot: Robot) -> FloatArray:
    """The initial pose, a little within the limits."""
    pose = []
    for c in robot.coordinates:
        room = c.upper - c.lower
        off = min(_FROM_LIMITS * room, REACH[c.unit]) if room > 0.0 else 0.0
        low, high = c.lower + off, c.upper - off
        q = min(max(c.initial, c.lower), c.upper)
        pose.append(min(max(q, low), high))
    return np.array(pose)


def _held_pose(
    robot: Robot, dynamics: CoreDynamics, pose: FloatArray, reasons: Mapping[str, str]
) -> tuple[Drivable, FloatArray]:
    """The pose where muscles drive most coordinates, the nearest of several."""
    free = [
        k
        for k, c in enumerate(robot.coordinates)
        if c.name not in reasons and not dynamics.dependent[k]
    ]
    best, at = _driven(robot, dynamics, pose, free), pose
    rng = np.random.default_rng(0)
    lower, upper = dynamics.q_min, dynamics.q_max
    spread = np.array([1.0 if c.unit == "rad" else 20.0 * _slide(robot) for c in robot.coordinates])
    spread = np.minimum(spread, np.where(np.isfinite(upper - lower), 0.4 * (upper - lower), np.inf))
    count = min(200, _SEARCHED // max(1, len(free)) ** 2) if len(free) else 0
    for k in range(count):
        if len(best.coordinates) == len(free):
            break
        away = rng.uniform(-1.0, 1.0, len(pose)) * spread * (k + 1) / count
        q = pose.copy()
        q[free] = np.clip(pose + away, lower, upper)[free]
        if dynamics.dependent.any():
            q = closed_or(dynamics, q, pose)
        found = _driven(robot, dynamics, q, free)
        if len(found.coordinates) > len(best.coordinates):
            best, at = found, q
    return best, at


def closed_or(
    dynamics: CoreDynamics, q: FloatArray, otherwise: FloatArray | None = None
) -> FloatArray:
    """The pose with closed loops; another one, or itself, where that is none."""
    try:
        return dynamics.closed(q)
    except InputError:
        return q if otherwise is None else otherwise


def _driven(robot: Robot, dynamics: CoreDynamics, q: FloatArray, free: list[int]) -> Drivable:
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    massless = massless_coordinates(robot, terms.M)
    return drivable(terms, [k for k in free if robot.coordinates[k].name not in massless])


def robot_size(robot: Robot) -> float:
    """How large the robot is, roughly, in [m]."""
    points = [p.position for m in robot.muscles for p in m.via_points]
    size = float(np.ptp(np.array(points), axis=0).max()) if points else 0.0
    offsets = [abs(x) for j in robot.joints for x in j.T_parent_joint.position]
    return max([size, *offsets]) or 1.0


def _slide(robot: Robot) -> float:
    """How far a sliding coordinate goes, in [m]: as becomes the robot's size."""
    return min(REACH["m"], _OF_REACH * robot_size(robot))


def _end(robot: Robot, dynamics: CoreDynamics, start: FloatArray, scale: float) -> FloatArray:
    """Where the motion goes from its start: as far as forces stay within their bounds."""
    slide = _slide(robot)
    step = np.zeros(len(start))
    for k, c in enumerate(robot.coordinates):
        if not dynamics.dependent[k]:
            most = scale * (REACH["rad"] if c.unit == "rad" else slide)
            ways = -min(most, 0.5 * (start[k] - c.lower)), min(most, 0.5 * (c.upper - start[k]))
            step[k] = _way(robot, dynamics, start, k, ways)
    for _ in range(_HALVINGS):
        if _margin_along(robot, dynamics, start, step, _PATH) > MARGIN:
            break
        step *= 0.5
    return closed_or(dynamics, start + step, start)


def _way(
    robot: Robot, dynamics: CoreDynamics, start: FloatArray, k: int, ways: tuple[float, float]
) -> float:
    """The way of one coordinate that leaves the forces more room, shorter where neither does."""
    for part in 0.5 ** np.arange(_HALVINGS):
        steps = [_one(k, part * way, start) for way in ways]
        margins = [_margin_along(robot, dynamics, start, step) for step in steps]
        room = [max(t - MARGIN, 0.0) * abs(way) for t, way in zip(margins, ways, strict=True)]
        if max(room) > 0.0:
            return float(part * ways[int(np.argmax(room))])
    return 0.0


def _one(k: int, way: float, like: FloatArray) -> FloatArray:
    step = np.zeros_like(like)
    step[k] = way
    return step


def _margin_along(
    robot: Robot,
    dynamics: CoreDynamics,
    start: FloatArray,
    step: FloatArray,
    path: FloatArray = np.ones(1),  # noqa: B008
) -> float:
    """The smallest margin of the forces along a quintic there, at some parts of its time."""
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


def lacks(robot: Robot, dynamics: CoreDynamics, q: FloatArray, found: Drivable) -> dict[int, str]:
    """In words, what every coordinate lacks that muscles cannot drive at a pose."""
    if not found.missing:
        return {}
    terms = pose_terms(robot, dynamics, q, np.zeros(len(q)))
    counted = np.full(dynamics.m, counted_force(robot))
    high = np.append(np.maximum(terms.high[: dynamics.m], counted), terms.high[dynamics.m :])
    strong = replace(terms, high=high)
    driven = drivable(strong, sorted([*found.coordinates, *found.missing])).coordinates
    words = {}
    for k, lack in found.missing.items():
        name = robot.coordinates[k].name
        if k in driven:
            words[k] = "what drives it is too weak; `cardsflow size` says what it needs"
        elif lack == "any muscle":
            words[k] = UNDRIVEN
        elif lack == "one of its own":
            words[k] = "muscles do not move it apart from the others, or by far too little"
        else:
            others = " while the others are held" if found.coordinates else ""
            words[k] = f"nothing pulls {name} {lack}{others}"
    return words


def _initial_mass(robot: Robot, dynamics: CoreDynamics) -> FloatArray:
    return dynamics.mass_matrix([c.initial for c in robot.coordinates])
