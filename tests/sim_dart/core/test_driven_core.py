"""Joints with functions, couplings and locks in the core: differences, energy, equal trees."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import inf
from typing import Any

import numpy as np
import pytest
from support.robots.driven import leg
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import (
    Coordinate,
    InputError,
    LimitForce,
    Polynomial,
    Robot,
    Term,
)
from addin_sdfusion.robot.model.coupling import all_values
from addin_sdfusion.robot.transforms.lock import lock
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses
from sim_dart.core.arrays import FloatArray
from sim_dart.dart.skeleton import build_skeleton
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.plant.plant import Plant
from sim_dart.plant.settings import Rule

STATES = [np.random.default_rng(seed).uniform(-0.9, 0.25, (2, 3)) * [[1], [3]] for seed in range(4)]


def with_coordinates(robot: Robot, change: Callable[[Coordinate], Coordinate]) -> Robot:
    joints = (
        replace(joint, coordinates=tuple(map(change, joint.coordinates))) for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


def differences(f: Callable[[FloatArray], FloatArray], q: FloatArray) -> FloatArray:
    """Return df/dq by Richardson extrapolation; the last index is the coordinate."""
    h = 2e-4

    def central(step: float) -> FloatArray:
        return np.stack(
            [(f(q + step * e) - f(q - step * e)) / (2 * step) for e in np.eye(len(q))], axis=-1
        )

    return (4 * central(h / 2) - central(h)) / 3


def limit_energy(force: LimitForce | None, x: float) -> float:
    """Return the energy of a limit force by Gauss quadrature, which is exact for each piece."""
    if force is None or force.low <= x <= force.high:
        return 0.0
    over, k = x - force.high, force.stiffness_high
    if x < force.low:
        over, k = force.low - x, force.stiffness_low
    nodes, weights = np.polynomial.legendre.leggauss(8)
    ends = sorted({0.0, min(over, force.transition), over})
    total = 0.0
    for a, b in pairwise(ends):
        e = a + 0.5 * (b - a) * (nodes + 1)
        y = np.minimum(e / force.transition, 1.0)
        total += 0.5 * (b - a) * float(weights @ (k * (10 * y**3 - 15 * y**4 + 6 * y**5) * e))
    return total


def energies(robot: Robot, q: FloatArray, qd: FloatArray) -> tuple[float, float]:
    """Return kinetic and potential energy from link poses and their finite differences."""
    poses = {link.name: np.zeros((4, 4)) for link in robot.links}

    def flat(x: FloatArray) -> FloatArray:
        return np.stack([link_poses(robot, x[None])[name][0] for name in poses])

    names = [c.name for c in robot.coordinates]

    def values(x: FloatArray) -> FloatArray:
        found = all_values(robot, dict(zip(names, x.tolist(), strict=True)))
        return np.array([found[c.name] for c in robot.all_coordinates])

    T, dT = flat(q), differences(flat, q) @ qd
    x, dx = values(q), differences(values, q) @ qd
    kinetic = potential = 0.0
    for link, pose, rate in zip(robot.links, T, dT, strict=True):
        W = rate[:3, :3] @ pose[:3, :3].T
        w = np.array([W[2, 1], W[0, 2], W[1, 0]])
        centre = np.array([*link.inertia.com, 1.0])
        v = (rate @ centre)[:3]
        inertia = pose[:3, :3] @ np.array(link.inertia.matrix) @ pose[:3, :3].T
        kinetic += 0.5 * link.inertia.mass * v @ v + 0.5 * w @ inertia @ w
        potential -= link.inertia.mass * np.array(robot.gravity) @ (pose @ centre)[:3]
    for c, value, speed in zip(robot.all_coordinates, x, dx, strict=True):
        kinetic += 0.5 * c.armature * speed**2
        potential += 0.5 * c.stiffness * (value - c.rest) ** 2 * (not c.locked)
        potential += limit_energy(c.limit_force, value)
    return kinetic, potential


@pytest.mark.slow
@pytest.mark.parametrize("state", STATES)
def test_all_terms_equal_derivatives_of_energies(state: FloatArray) -> None:
    """Compare with Lagrange's equations, using numpy link poses and finite differences."""
    (q, qd), robot = state, leg()
    dynamics = CoreDynamics(robot)
    M = dynamics.mass_matrix(q)
    assert energies(robot, q, qd)[0] == pytest.approx(0.5 * qd @ M @ qd, rel=1e-10)
    G = differences(lambda x: np.array(energies(robot, x, qd)[1]), q)
    np.testing.assert_allclose(dynamics.gravity(q), G, atol=1e-8)
    dM = differences(dynamics.mass_matrix, q)
    C = np.einsum("kji,i,j->k", dM, qd, qd) - 0.5 * np.einsum("ijk,i,j->k", dM, qd, qd)
    np.testing.assert_allclose(dynamics.coriolis(q, qd), C, atol=1e-8)
    J = differences(dynamics.task_position, q)
    np.testing.assert_allclose(dynamics.task_jacobian(q), J, atol=1e-8)
    bias = np.einsum("kij,i,j->k", differences(dynamics.task_jacobian, q), qd, qd)
    np.testing.assert_allclose(dynamics.task_bias(q, qd), bias, atol=1e-8)
    L = differences(dynamics.muscle_lengths, q)
    np.testing.assert_allclose(dynamics.muscle_jacobian(q), L, atol=1e-8)


def with_polynomials(robot: Robot) -> Robot:
    """Return the same robot with identity polynomials as motion functions."""
    itself = Polynomial((0.0, 1.0, 0.0))
    joints = (
        replace(joint, motions=tuple(replace(m, function=itself) for m in joint.motions))
        for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
@pytest.mark.parametrize("seed", range(2))
def test_mass_matrix_and_articulated_bodies_give_the_same_motion(
    seed: int, integrator: Rule
) -> None:
    """Include limits, friction, springs, damping, armature, loads and wrenches."""
    robot = with_coordinates(
        random_robot(seed, joints=5, muscles=4),
        lambda c: replace(
            c, lower=-0.6, upper=0.7, initial=0.1, damping=0.2, stiffness=3.0, rest=0.2,
            friction=0.05 * (integrator == "euler"), armature=0.1,
        ),
    )  # fmt: skip
    words: dict[str, Any] = {"integrator": integrator, "energy": True, "wrenched": ["link_2"]}
    plants = [Plant(form, 1e-3, **words) for form in (robot, with_polynomials(robot))]
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-0.5, 0.6, 5), rng.normal(0.0, 3.0, 5)
    for plant in plants:
        plant.reset(q, qd)
    for _ in range(100):
        f, w, load = rng.uniform(0.0, 20.0, 4), rng.normal(0.0, 5.0, 6), rng.normal(0.0, 5.0, 6)
        for plant in plants:
            plant.step(f, loads=load, wrenches=w)
    np.testing.assert_allclose(plants[1].q, plants[0].q, rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(plants[1].qd, plants[0].qd, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(plants[1].energy, plants[0].energy, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(plants[1].momentum, plants[0].momentum, rtol=1e-8, atol=1e-9)


def test_energy_error_has_the_order_of_the_integrator() -> None:
    """Include armature and springs of coupled coordinates, with and without damping."""
    drifts = []
    still = with_coordinates(leg(), lambda c: replace(c, lower=-inf, upper=inf))
    for step in (2e-3, 1e-3):
        plant = Plant(still, step, integrator="rk4", energy=True)
        plant.reset([0.3, -0.5, 0.05], [0.5, -1.0, 0.4])
        before = plant.energy
        for _ in range(round(0.3 / step)):
            plant.step([20.0, 10.0, 5.0])
        now = plant.energy
        assert now.damping_work < -1e-3
        gained = now.kinetic + now.potential - before.kinetic - before.potential
        drifts.append(abs(gained - sum(now[2:])))
    assert drifts[1] < 1e-7
    assert drifts[1] < drifts[0] / 8


def test_coupled_hinge_equals_geared_hinge() -> None:
    """A second hinge coupled to the first equals one hinge with 1 + k times the rotation."""
    robot = planar_2r()
    name = robot.coordinates[0].name
    gear = Polynomial((0.3, -1.0))
    coupled = with_coordinates(
        robot, lambda c: c if c.name == name else replace(c, coupling=(Term(name, gear),))
    )
    plain, driven = CoreDynamics(robot), CoreDynamics(coupled)
    q, qd, G = np.array([0.4]), np.array([1.3]), np.array([[1.0], [-1.0]])
    both, rates = np.array([0.4, 0.3 - 0.4]), G @ qd
    np.testing.assert_allclose(driven.mass_matrix(q), G.T @ plain.mass_matrix(both) @ G)
    bias = plain.coriolis(both, rates) + plain.gravity(both)
    np.testing.assert_allclose(driven.coriolis(q, qd) + driven.gravity(q), G.T @ bias)
    np.testing.assert_allclose(driven.muscle_jacobian(q), plain.muscle_jacobian(both) @ G)
    np.testing.assert_allclose(driven.task_jacobian(q), plain.task_jacobian(both) @ G)
    np.testing.assert_allclose(driven.task_bias(q, qd), plain.task_bias(both, rates), atol=1e-14)


def test_locked_coordinate_does_not_move() -> None:
    robot = planar_2r()
    first, second = (c.name for c in robot.coordinates)
    locked = with_coordinates(
        robot, lambda c: c if c.name == first else replace(c, locked=True, initial=0.7)
    )
    plain, held = CoreDynamics(robot), CoreDynamics(locked)
    assert held.coordinate_names == (first,)
    M = plain.mass_matrix([0.4, 0.7])[:1, :1]
    np.testing.assert_allclose(held.mass_matrix([0.4]), M, rtol=1e-13)
    np.testing.assert_allclose(held.gravity([0.4]), plain.gravity([0.4, 0.7])[:1], rtol=1e-13)
    assert lock(robot, {second: 0.7}).coordinates == locked.coordinates


def test_dart_rejects_unsupported_features() -> None:
    with pytest.raises(InputError, match="joint 'knee': functions, couplings and locks"):
        build_skeleton(leg())
