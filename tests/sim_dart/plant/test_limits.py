"""Simultaneous joint limits compared with Gauss's principle of least constraint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from support.robots.random_robots import random_tree
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Robot
from sim_dart import CoreDynamics, Plant

STEP = 1e-3
LIMITS = ((-0.01, 0.01), (-np.inf, 0.005), (-np.inf, np.inf))


def with_limits(robot: Robot, limits: Callable[[], tuple[float, float]]) -> Robot:
    joints = []
    for joint in robot.joints:
        ends = [limits() for _ in joint.coordinates]
        pairs = zip(joint.coordinates, ends, strict=True)
        made = tuple(replace(c, lower=low, upper=high) for c, (low, high) in pairs)
        joints.append(replace(joint, coordinates=made))
    return replace(robot, joints=tuple(joints))


def narrow_tree(seed: int) -> Robot:
    """Return a damped tree with narrow limits."""
    rng = np.random.default_rng(seed)
    return with_limits(random_tree(seed, damping=0.3), lambda: LIMITS[rng.integers(3)])


def constrained_velocities(
    M: np.ndarray, free: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray[Any, Any]:
    """Return the velocities within the bounds that minimise (v - free)' M (v - free)."""
    root = np.linalg.cholesky(M).T
    bounds = low, np.maximum(high, low + 1e-300)
    found: np.ndarray = lsq_linear(root, root @ free, bounds, method="bvls", tol=1e-14).x
    return found


def free_plant(robot: Robot, **settings: Any) -> Plant:
    return Plant(with_limits(robot, lambda: (-np.inf, np.inf)), STEP, engine="core", **settings)


@pytest.mark.native
@pytest.mark.parametrize("seed", range(12))
def test_core_step_satisfies_all_limits_simultaneously(seed: int) -> None:
    robot = narrow_tree(seed)
    plant, free, d = Plant(robot, STEP, engine="core"), free_plant(robot), CoreDynamics(robot)
    rng = np.random.default_rng(seed)
    plant.reset(None, rng.uniform(-1, 1, d.n))
    met = 0
    for _ in range(50):
        q, f = plant.q, rng.uniform(0, 50, d.m)
        free.reset(q, plant.qd)
        free.step(f)
        plant.step(f)
        low, high = (d.q_min - q) / STEP, (d.q_max - q) / STEP
        expected = constrained_velocities(d.mass_matrix(q), free.qd, low, high)
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(plant.qd, expected, rtol=0, atol=1e-10 * scale)
        assert (plant.q >= d.q_min - 1e-12).all()
        assert (plant.q <= d.q_max + 1e-12).all()
        met = max(met, int(np.sum(expected != free.qd)))
    assert met > 1


@pytest.mark.parametrize("seed", [3, 7, 12])
def test_rk4_stops_are_inelastic(seed: int) -> None:
    """In trees 7 and 12, moving joints follow a fixed joint."""
    robot = narrow_tree(seed)
    plant = Plant(robot, STEP, integrator="rk4")
    free, d = free_plant(robot, integrator="rk4"), CoreDynamics(robot)
    rng = np.random.default_rng(seed)
    start = rng.uniform(-1, 1, d.n)
    plant.reset(None, start)
    met = 0
    for _ in range(50):
        f = rng.uniform(0, 50, d.m)
        free.reset(plant.q, plant.qd)
        free.step(f)
        plant.step(f)
        under, over = free.q < d.q_min, free.q > d.q_max
        q = np.clip(free.q, d.q_min, d.q_max)
        low, high = np.where(under, 0.0, -np.inf), np.where(over, 0.0, np.inf)
        expected = constrained_velocities(d.mass_matrix(q), free.qd, low, high)
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(plant.q, q, rtol=0, atol=1e-12)
        np.testing.assert_allclose(plant.qd, expected, rtol=0, atol=1e-10 * scale)
        met = max(met, int(np.sum(under | over)))
    assert met > 1


@pytest.mark.parametrize("beyond", [1e-4, 0.1, 1.0])
def test_joint_beyond_its_limit_returns_slowly(beyond: float) -> None:
    """It returns within a step, or with at most 10 rad/s, with both engines."""
    robot = with_limits(planar_2r(), lambda: (-0.4, 0.4))
    core, dart = (Plant(robot, STEP, engine=engine) for engine in ("core", "dart"))
    for plant in (core, dart):
        plant.reset([0.4 + beyond, 0.1])
    for _ in range(5):
        for plant in (core, dart):
            plant.step(np.zeros(4))
        assert core.qd[0] == pytest.approx(dart.qd[0], abs=1e-6)
        assert core.qd[0] >= -10.0 - 1e-9
        np.testing.assert_allclose(core.q, dart.q, rtol=0, atol=1e-9)
    if beyond < 0.01:
        assert core.q[0] <= 0.4
