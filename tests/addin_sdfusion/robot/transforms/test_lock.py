"""Robots with locked coordinates move like the full robot with constant coordinates."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    Inertia,
    InputError,
    Joint,
    Link,
    Motion,
    Robot,
    UnknownNameError,
    check,
)
from addin_sdfusion.robot.transforms.lock import lock
from sim_dart import CoreDynamics, DartDynamics


def assert_holds(robot: Robot, held: list[int], seed: int, dynamics: type) -> None:
    """Compare M, C, G, l, L, y and J of the locked robot with rows and columns of the full one."""
    names = [c.name for c in robot.coordinates]
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1.0, 1.0, (2, len(names)))
    qd[held] = 0.0
    locked = lock(robot, {names[k]: q[k] for k in held})
    left = [k for k in range(len(names)) if k not in held]
    assert [c.name for c in locked.coordinates] == [names[k] for k in left]
    assert [f for f in check(locked) if f.is_error] == []
    a, b = dynamics(robot), dynamics(locked)
    close(a.mass_matrix(q)[np.ix_(left, left)], b.mass_matrix(q[left]))
    close(a.coriolis(q, qd)[left], b.coriolis(q[left], qd[left]))
    close(a.gravity(q)[left], b.gravity(q[left]))
    close(a.muscle_lengths(q), b.muscle_lengths(q[left]))
    close(a.muscle_jacobian(q)[:, left], b.muscle_jacobian(q[left]))
    if robot.task_frames:
        close(a.task_position(q), b.task_position(q[left]))
        close(a.task_jacobian(q)[:, left], b.task_jacobian(q[left]))


def close(one: np.ndarray, other: np.ndarray) -> None:
    np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-11 * max(1.0, np.abs(one).max()))


@pytest.mark.parametrize("dynamics", [CoreDynamics, DartDynamics])
@pytest.mark.parametrize("seed", range(6))
def test_remaining_coordinates_move_as_before(seed: int, dynamics: type) -> None:
    robot = random_robot(seed)
    n = len(robot.coordinates)
    rng = np.random.default_rng(100 + seed)
    for count in {1, n // 2, n - 1} - {0}:
        assert_holds(robot, sorted(rng.choice(n, count, replace=False)), seed, dynamics)


@pytest.mark.parametrize("seed", range(20))
def test_any_joint_type_can_keep_some_coordinates(seed: int) -> None:
    robot = every_joint()
    n = len(robot.coordinates)
    rng = np.random.default_rng(seed)
    assert_holds(robot, sorted(rng.choice(n, n // 2, replace=False)), seed, CoreDynamics)


def compound(q: float) -> Robot:
    x, z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    motions = (Motion("rotation", z, 0), Motion("translation", x, 1), Motion("rotation", x, 2))
    joint = Joint(
        "odd",
        WORLD,
        "link",
        motions,
        (Coordinate("a"), Coordinate("b", unit="m"), Coordinate("c")),
    )
    robot = Robot("odd", (Link("link", Inertia(1.0, z, 1.0, 1.0, 1.0)),), (joint,))
    return lock(robot, {"b": q})


def test_translation_between_rotations_can_only_be_locked_at_zero() -> None:
    assert [c.name for c in compound(0.0).coordinates] == ["a", "c"]
    with pytest.raises(InputError, match=r"coordinates\.b\.locked.*only be locked at 0"):
        compound(0.1)


def test_unknown_coordinates_are_reported() -> None:
    with pytest.raises(UnknownNameError, match="coordinate"):
        lock(random_robot(0), {"nowhere": 0.0})
