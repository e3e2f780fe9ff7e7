"""Coulomb friction of joints in the C core: friction law, closed forms, and DART."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.robots.plants import steps
from support.robots.random_robots import random_tree
from support.robots.robots import chain, one_joint, planar_2r, with_coordinates

from addin_sdfusion.robot import (
    Inertia,
    InputError,
    Robot,
    prismatic,
    revolute,
)
from sim_dart import CoreDynamics, Plant
from sim_dart.core.arrays import FloatArray

STEP = 1e-3
LIMITS = ((-0.01, 0.01), (-np.inf, 0.005), (-np.inf, np.inf), (0.0, 0.02))
MASS = 2.0


def with_friction_and_limits(robot: Robot, rng: np.random.Generator, most: float) -> Robot:
    """Return the robot with friction in two thirds of the coordinates, and narrow limits."""
    joints = []
    for joint in robot.joints:
        made = []
        for coordinate in joint.coordinates:
            low, high = LIMITS[rng.integers(len(LIMITS))]
            friction = most * rng.uniform(0, 1) * (rng.uniform() < 0.67)
            made.append(replace(coordinate, lower=low, upper=high, friction=friction))
        joints.append(replace(joint, coordinates=tuple(made)))
    return replace(robot, joints=tuple(joints))


def without_friction_and_limits(robot: Robot) -> Robot:
    """Return the robot without friction and limits."""
    return with_coordinates(robot, lower=-np.inf, upper=np.inf, friction=0.0)


def frictions(robot: Robot) -> FloatArray:
    return np.array([c.friction for c in robot.coordinates])


def assert_law(
    M: FloatArray,
    free: FloatArray,
    v: FloatArray,
    low: FloatArray,
    high: FloatArray,
    grip: FloatArray,
    near: float = 1e-9,
) -> None:
    """Check that the impulses M (v - free) satisfy the friction law and the limits.

    The corresponding cost is convex, so a velocity that satisfies the law is its minimum.
    """
    p = M @ (v - free)
    scale = np.abs(M) @ np.abs(v - free) + grip + 1e-3
    speed = 1e-12 * (1.0 + np.abs(v))
    for j in range(v.size):
        assert low[j] - speed[j] <= v[j] <= high[j] + speed[j]
        at_low, at_high = v[j] <= low[j] + speed[j], v[j] >= high[j] - speed[j]
        down, up = v[j] < -speed[j], v[j] > speed[j]
        most = np.inf if at_low else (-grip[j] if up else grip[j])
        least = -np.inf if at_high else (grip[j] if down else -grip[j])
        assert least - near * scale[j] <= p[j] <= most + near * scale[j]


@pytest.mark.slow
@pytest.mark.native
def test_steps_satisfy_friction_law_and_limits() -> None:
    """Check random trees at random velocities with sliding, stopped and sticking joints."""
    ways = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        robot = with_friction_and_limits(
            random_tree(seed, damping=0.3), rng, 10.0 ** rng.uniform(-1, 2)
        )
        plant, free = (
            Plant(r, STEP, engine="core") for r in (robot, without_friction_and_limits(robot))
        )
        d, grip = CoreDynamics(robot), STEP * frictions(robot)
        plant.reset(None, rng.uniform(-1, 1, d.n) * rng.integers(0, 2, d.n))
        for _ in range(60):
            q, f = plant.q, rng.uniform(0, 50, d.m)
            free.reset(q, plant.qd)
            free.step(f)
            plant.step(f)
            low = np.minimum((d.q_min - q) / STEP, 10.0)
            high = np.maximum((d.q_max - q) / STEP, -10.0)
            assert_law(d.mass_matrix(q), free.qd, plant.qd, low, high, grip)
            ways |= set(zip(np.sign(plant.qd).tolist(), (grip > 0).tolist(), strict=True))
    assert len(ways) == 6  # down, at rest and up, with and without friction


@pytest.mark.slow
def test_chains_of_twenty_joints_satisfy_the_friction_law() -> None:
    """The solver converges for two thousand states."""
    robot = with_friction_and_limits(chain(20, 0), np.random.default_rng(0), 5.0)
    plant, free = (
        Plant(r, STEP, engine="core") for r in (robot, without_friction_and_limits(robot))
    )
    d, grip, rng = CoreDynamics(robot), STEP * frictions(robot), np.random.default_rng(1)
    ways = set()
    for _ in range(2000):
        q = rng.uniform(-0.01, 0.02, d.n)
        qd = 10.0 ** rng.uniform(-3, 1) * rng.uniform(-1, 1, d.n)
        for one in (plant, free):
            one.reset(q, qd)
            one.step([])
        low = np.minimum((d.q_min - q) / STEP, 10.0)
        high = np.maximum((d.q_max - q) / STEP, -10.0)
        assert_law(d.mass_matrix(q), free.qd, plant.qd, low, high, grip, 1e-8)
        ways.add(int(np.sum(plant.qd == 0.0)))
    assert len(ways) > 5


@pytest.mark.parametrize("seed", range(12))
def test_friction_and_stops_dissipate_energy(seed: int) -> None:
    """Compare the energy after a step with the energy without friction and limits."""
    rng = np.random.default_rng(seed)
    robot = with_friction_and_limits(random_tree(seed), rng, 3.0)
    plant, free = (
        Plant(r, STEP, engine="core") for r in (robot, without_friction_and_limits(robot))
    )
    d = CoreDynamics(robot)
    plant.reset(None, rng.uniform(-1, 1, d.n))
    taken = 0.0
    for _ in range(100):
        M = d.mass_matrix(plant.q)
        free.reset(plant.q, plant.qd)
        for one in (plant, free):
            one.step(np.zeros(d.m))
        before, after = (0.5 * one.qd @ M @ one.qd for one in (free, plant))
        assert after <= before * (1 + 1e-12)
        taken += before - after
    assert taken > 1e-6


def slider(friction: float, **more: Any) -> Robot:
    """Return a mass on a rail along x."""
    solid, along_x = Inertia(MASS, ixx=0.1, iyy=0.1, izz=0.1), prismatic((1.0, 0.0, 0.0))
    return one_joint("rail", along_x, solid, friction=friction, actuated=True, unit="m", **more)


def test_sliding_mass_stops_and_sticks() -> None:
    """The velocity decreases by h F/m per step. Smaller forces do not move the mass again."""
    force, speed = 3.1, 0.5
    plant = Plant(slider(force), STEP)
    assert plant.engine == "core"
    plant.reset([0.0], [speed])
    loss = STEP * force / MASS
    whole = int(speed / loss)
    speeds = speed - loss * np.arange(1, whole + 1)
    steps(plant, whole + 10, [])
    assert plant.qd[0] == 0.0
    assert plant.q[0] == pytest.approx(STEP * speeds.sum(), abs=1e-12)
    assert plant.q[0] == pytest.approx(0.5 * MASS * speed**2 / force, rel=0.01)
    rest = plant.q[0]
    for load in (0.999 * force, -0.999 * force):
        steps(plant, 100, [], [load])
        assert plant.q[0] == rest
        assert plant.qd[0] == 0.0
    plant.step([], [force + 1.0])
    assert plant.qd[0] == pytest.approx(STEP * 1.0 / MASS, rel=1e-12)


def test_friction_acts_at_joint_limits() -> None:
    """A force that moves a joint away from its limit must exceed the friction."""
    plant = Plant(slider(2.0, upper=0.1, lower=-1.0), STEP)
    plant.reset([0.0], [1.0])
    steps(plant, 300, [], [5.0])
    assert plant.q[0] == pytest.approx(0.1, abs=1e-15)
    steps(plant, 10, [], [-1.99])
    assert plant.qd[0] == 0.0
    plant.step([], [-3.0])
    assert plant.qd[0] == pytest.approx(-STEP * 1.0 / MASS, rel=1e-12)


@pytest.mark.slow
def test_mass_on_a_spring_loses_constant_amplitude_per_half_swing() -> None:
    """The amplitude decreases by 2 F/k per half swing until the mass sticks."""
    stiffness, force, h = 50.0, 1.0, 5e-5
    plant = Plant(slider(force, stiffness=stiffness, rest=0.0), h)
    plant.reset([0.31])
    way = [0.31]
    for _ in range(110000):
        plant.step([])
        way.append(plant.q[0])
    moved = np.array(way)[np.append(True, np.diff(way) != 0.0)]
    inner = np.flatnonzero(np.diff(np.sign(np.diff(moved)))) + 1
    turns = np.abs(moved[[0, *inner, -1]])
    expected = np.abs(0.31 - 2 * force / stiffness * np.arange(9))
    np.testing.assert_allclose(turns, expected, rtol=0, atol=8e-4)
    assert plant.qd[0] == 0.0
    assert abs(plant.q[0]) <= force / stiffness


def test_pendulum_with_friction_stops() -> None:
    """It first stops at m g l (cos b - cos a) = F (a - b) and sticks."""
    length, friction = 0.5, 4.0
    bob = Inertia(MASS, (0.0, 0.0, -length), ixx=1e-6, iyy=1e-6, izz=1e-6)
    robot = one_joint("hinge", revolute((0.0, 1.0, 0.0)), bob, friction=friction)
    plant = Plant(robot, 1e-4, energy=True)
    weight = MASS * 9.81 * length
    plant.reset([1.2])
    begin = plant.energy
    steps(plant, 20000, [])
    stop = plant.q[0]
    assert plant.qd[0] == 0.0
    assert weight * abs(np.sin(stop)) < friction
    if begin.potential:
        lost = weight * (np.cos(stop) - np.cos(1.2))
        assert lost == pytest.approx(friction * (1.2 - stop), rel=1e-3)
        assert begin.potential - plant.energy.potential == pytest.approx(lost, rel=1e-9)
    steps(plant, 100, [])
    assert plant.q[0] == stop


@pytest.mark.cases(6)
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_friction_equals_dart(seed: int) -> None:
    """Compare 0.5 s of a tree that comes to rest. DART softens impulses by 1e-9."""
    rng = np.random.default_rng(seed)
    robot = with_coordinates(random_tree(seed, damping=0.2), friction=1.5)
    core, dart = (Plant(robot, STEP, engine=engine) for engine in ("core", "dart"))
    start = rng.uniform(-0.5, 0.5, core.qd.size)
    for plant in (core, dart):
        plant.reset(None, start)
    slid = held = 0
    for _ in range(500):
        for plant in (core, dart):
            plant.step(np.full(4, 1.0))
        np.testing.assert_allclose(core.q, dart.q, rtol=0, atol=1e-9)
        slid, held = slid + np.sum(core.qd != 0.0), held + np.sum(core.qd == 0.0)
    assert slid
    assert held


def test_state_is_restored_bit_identically() -> None:
    """Steps do not depend on earlier sticking joints."""
    rng = np.random.default_rng(3)
    plant = Plant(with_friction_and_limits(planar_2r(), rng, 5.0), STEP)
    for _ in range(50):
        plant.step(rng.uniform(0, 30, 4))
    state = plant.get_state()
    commands = rng.uniform(0, 30, (50, 4))
    rows = []
    for _ in range(2):
        plant.set_state(state)
        for f in commands:
            plant.step(f)
        rows.append(plant.get_state())
    np.testing.assert_array_equal(*rows)


def test_rk4_is_rejected() -> None:
    with pytest.raises(InputError, match=r"rk4 does not support Coulomb friction.*rail"):
        Plant(slider(1.0), integrator="rk4")
