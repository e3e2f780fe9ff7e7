"""Cables, springs and the McKibben muscle: closed forms, and common properties of all laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from support.robots.muscle_bench import SOUND, Bench, slider
from support.robots.random_robots import random_robot

from addin_sdfusion.robot import CableModel, Robot, check
from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.laws import MuscleLaws

pytestmark = pytest.mark.native


def test_elastic_cable_has_stiffness_and_damping_and_becomes_slack() -> None:
    bench = Bench(("elastic_cable", {"stiffness": 2e4, "damping": 30.0}))
    assert bench.tension(0.31, 0.0, 0.3) == pytest.approx(200.0, rel=1e-12)
    assert bench.tension(0.31, 2.0, 0.3) == pytest.approx(260.0, rel=1e-12)
    assert bench.tension(0.31, -100.0, 0.3) == 0.0
    assert bench.tension(0.29, 2.0, 0.3) == 0.0
    assert bench.tension(0.3, 0.0, -5.0) == pytest.approx(
        6000.0, rel=1e-12
    )  # the rest length is at least 0


def test_caspr_spring_can_pull_and_push() -> None:
    bench = Bench(("passive_spring", {"K": 400.0, "l0": 0.3}))
    assert bench.tension(0.35, 9.0, 0.0) == pytest.approx(20.0, rel=1e-12)
    assert bench.tension(0.25, 9.0, 0.0) == pytest.approx(-20.0, rel=1e-12)
    assert bench.laws.torques[0] == pytest.approx(20.0, rel=1e-12)  # directed away from the world


def test_mckibben_force_equals_virtual_work_of_its_volume() -> None:
    """Compare with f = -p dV/dL, with V from the geometry of the sleeve."""
    b, n, cord = 0.35, 1.5, 0.05
    bench = Bench(("mckibben", SOUND["mckibben"]))

    def volume(length: float) -> float:
        return (b**2 - length**2) * length / (4 * math.pi * n**2)

    for length in (0.21, 0.25, 0.3, 0.34):
        for pressure in (0.0, 1e5, 6e5):
            slope = (volume(length + 1e-6) - volume(length - 1e-6)) / 2e-6
            found = bench.tension(length + cord, 0.7, 0.0, [pressure])
            assert found == pytest.approx(max(-pressure * slope, 0.0), rel=1e-8, abs=1e-8)
    shortest = b / math.sqrt(3.0)
    assert bench.tension(shortest - 1e-6 + cord, 0.0, 0.0, [6e5]) == 0.0
    assert bench.tension(0.01, 0.0, 0.0, [6e5]) == 0.0  # the path is shorter than the cord


@pytest.mark.parametrize("h", [1e-4, 1e-2, 10.0])
def test_pressure_equals_the_exact_solution(h: float) -> None:
    bench = Bench(("mckibben", SOUND["mckibben"]))
    bench.start(0.3, 1e5)
    for k in range(1, 6):
        bench.advance(0.3, 0.0, 9e5, h)  # beyond the largest: 6e5
        expected = 6e5 - 5e5 * math.exp(-k * h / 0.05)
        assert bench.laws.states[0] == pytest.approx(expected, rel=1e-12)
    assert bench.state_rates(0.3, 0.0, 2e5, [1e5])[0] == pytest.approx(1e5 / 0.05, rel=1e-12)


def test_pressure_without_time_constant_equals_its_command() -> None:
    bench = Bench(("mckibben", SOUND["mckibben"] | {"pressure_time_constant": 0.0}))
    bench.start(0.3, 0.0)
    bench.advance(0.3, 0.0, 2e5, 1e-3)
    assert bench.laws.states[0] == 2e5


def _with_laws(seed: int) -> Robot:
    """Return a random robot with all laws except heavy cables in turn."""
    light = [(kind, p) for kind, p in SOUND.items() if kind != "heavy_cable"]
    robot = random_robot(seed, muscles=len(light))
    group = robot.cable_sets[0]
    models = [CableModel(k, tuple(p.items())) for k, p in light]  # type: ignore[arg-type]
    muscles = tuple(
        replace(muscle, model=model) for muscle, model in zip(group.muscles, models, strict=True)
    )
    return replace(robot, cable_sets=(replace(group, muscles=muscles),))


@pytest.mark.parametrize("seed", range(5))
def test_rates_and_torques_equal_the_jacobian_products(seed: int) -> None:
    """Rates are L qd and torques are -L'f, so the power of muscles and joints is equal."""
    robot = _with_laws(seed)
    core = Core(compile_blob(robot))
    laws = MuscleLaws(robot, core)
    m, n = len(robot.muscles), len(robot.coordinates)
    rng = np.random.default_rng(seed)
    q, qd, commands = rng.normal(size=n), rng.normal(size=n), rng.uniform(0.0, 1.0, m)
    core.move(core.handle, q.tobytes())
    L = core.array("jacobian", m, n)
    laws.start(commands)
    f = laws.drive(qd, commands)
    np.testing.assert_allclose(laws.rates, L @ qd, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(laws.torques, -L.T @ f, rtol=1e-12, atol=1e-9)
    assert float(laws.torques @ qd) == pytest.approx(-float(f @ laws.rates), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_tension_of_ideal_cables_equals_their_command(seed: int) -> None:
    """Tensions are bit-identical, also for slack cables."""
    robot = random_robot(seed)
    core = Core(compile_blob(robot))
    laws = MuscleLaws(robot, core)
    m, n = len(robot.muscles), len(robot.coordinates)
    rng = np.random.default_rng(seed)
    core.move(core.handle, rng.normal(size=n).tobytes())
    f = rng.normal(scale=50.0, size=m)
    core.pull(core.handle, f.tobytes())
    pulled = core.array("torques", n).copy()
    laws.drive(rng.normal(size=n), f)
    np.testing.assert_array_equal(laws.torques, pulled)
    np.testing.assert_array_equal(laws.tensions, np.maximum(f, 0.0))
    assert not laws.states.size


@pytest.mark.parametrize("kind", SOUND)
def test_core_accepts_every_checked_law_and_results_are_finite(kind: str) -> None:
    """Set each parameter to values near, at and far outside its bounds."""
    law, taken = MUSCLE_LAWS[kind], 0
    for parameter in law.parameters:
        extremes = {parameter.low, parameter.high, -1.0, 0.0, 1e-300, 1e-9, 1e9, 1e300}
        for value in sorted(extremes):
            values = SOUND[kind] | {parameter.name: value}
            codes = {finding.code for finding in check(slider((kind, values))) if finding.is_error}
            if codes - {"passive-cable-force"}:  # due to the force limits of the bench
                continue
            bench, taken = Bench((kind, values)), taken + 1
            for length in (0.25, 0.4):
                tensions = [bench.start(length, 1.0)]
                for _ in range(5):
                    bench.advance(length, 0.1, 1.0, 1e-3)
                    tensions.append(bench.tension(length, 0.1, 1.0))
                assert np.isfinite([*tensions, *bench.laws.states]).all(), (parameter.name, value)
    assert taken > 0 or not law.parameters
