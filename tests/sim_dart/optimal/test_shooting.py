"""Intervals of motions: their ends equal steps of the plant, their derivatives differences."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import Robot
from cardsflow_fmu import Experiment
from sim_dart import Plant
from sim_dart.optimal.shooting import Shooting

COUNT, H, STEPS = 20, 0.02, 2


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Experiment.load(PLANAR_2R).robot


def _arguments(shooting: Shooting) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.4, 0.4, (COUNT, shooting.nx))
    return x, rng.uniform(10.0, 60.0, (COUNT, shooting.nu)), np.full(COUNT, H)


def test_ends_equal_those_of_the_plant(robot: Robot) -> None:
    shooting = Shooting(robot, STEPS)
    x, u, h = _arguments(shooting)
    found = shooting.run(x, u, h)
    plain = shooting.run(x, u, h, derivatives=False)
    assert found is not None
    assert plain is not None
    np.testing.assert_allclose(found.ends, plain.ends, rtol=1e-13, atol=1e-13)
    plant = Plant(robot, step=H / STEPS, integrator="rk4")
    for start, forces, end in zip(x, u, plain.ends, strict=True):
        plant.reset(start[:2], start[2:])
        for _ in range(STEPS):
            plant.step(forces)
        np.testing.assert_allclose([*plant.q, *plant.qd], end, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("threads", [1, 3])
def test_derivatives_match_differences(robot: Robot, threads: int) -> None:
    shooting, e = Shooting(robot, STEPS, threads), 1e-6
    x, u, h = _arguments(shooting)
    found = shooting.run(x, u, h)
    assert found is not None
    rng = np.random.default_rng(1)
    dx, du, dh = rng.normal(size=x.shape), 10.0 * rng.normal(size=u.shape), rng.normal(size=COUNT)
    ends = [shooting.run(x + s * dx, u + s * du, h + s * dh, False) for s in (e, -e)]
    assert ends[0] is not None
    assert ends[1] is not None
    along = np.einsum("kij,kj->ki", found.A, dx) + np.einsum("kij,kj->ki", found.B, du)
    along += found.c * dh[:, None]
    np.testing.assert_allclose(along, (ends[0].ends - ends[1].ends) / (2 * e), rtol=1e-6, atol=1e-6)


def test_derivatives_with_muscle_laws_match_differences() -> None:
    """Commands and activations of Hill-type muscles."""
    robot = Experiment.load(EXAMPLES / "hill_arm").robot
    shooting, e = Shooting(robot, STEPS, with_laws=True), 1e-6
    assert shooting.nx == 4 + 6  # one activation per muscle
    rng = np.random.default_rng(2)
    x = rng.uniform(0.2, 0.8, (COUNT, shooting.nx))
    u, h = rng.uniform(0.2, 0.8, (COUNT, 6)), np.full(COUNT, H)
    found = shooting.run(x, u, h)
    assert found is not None
    dx, du = rng.normal(size=x.shape), rng.normal(size=u.shape)
    ends = [shooting.run(x + s * dx, u + s * du, h, False) for s in (e, -e)]
    assert ends[0] is not None
    assert ends[1] is not None
    along = np.einsum("kij,kj->ki", found.A, dx) + np.einsum("kij,kj->ki", found.B, du)
    np.testing.assert_allclose(along, (ends[0].ends - ends[1].ends) / (2 * e), rtol=1e-6, atol=1e-6)


def test_rates_are_the_derivatives_by_time(robot: Robot) -> None:
    shooting, e = Shooting(robot, STEPS), 1e-6
    x, u, h = _arguments(shooting)
    short = shooting.run(x, u, 0 * h + e, False), shooting.run(x, u, 0 * h - e, False)
    assert short[0] is not None
    assert short[1] is not None
    rates = (short[0].ends - short[1].ends) / (2 * e)
    np.testing.assert_allclose(shooting.rates(x, u), rates, rtol=1e-6, atol=1e-6)


def test_diverging_motion_is_reported(robot: Robot) -> None:
    shooting = Shooting(robot)
    x, u, h = _arguments(shooting)
    assert shooting.run(x, u * 1e300, h) is None
