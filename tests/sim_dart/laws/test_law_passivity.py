"""Passivity of muscle laws: no generated energy, no pushing forces, finite results."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, SOUND, Bench

from addin_sdfusion.robot.model.laws import MUSCLE_LAWS
from addin_sdfusion.robot.model.muscle_laws import command_range, states_of
from addin_sdfusion.robot.model.muscle_laws import law_of as _law_of
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

ELASTIC = HILL | {"elastic_tendon": 1.0}
BY_LENGTH = ("elastic_cable", "heavy_cable")
CASES = [*SOUND.items(), *((k, ELASTIC) for k in SOUND if k.startswith("hill"))]
PUSHING = ("passive_spring", "tendon_spring")
PULLING = [case for case in CASES if case[0] not in PUSHING]
ABSURD = (0.0, 1e-300, 1e-9, 0.1, 0.3, 1.0, 50.0, 1e6, 1e12, 1e150)


def _ids(cases: list[tuple[str, dict[str, float]]]) -> list[str]:
    return [kind + ("-elastic" if "elastic_tendon" in p else "") for kind, p in cases]


@pytest.mark.parametrize(("kind", "parameters"), PULLING, ids=_ids(PULLING))
def test_tension_is_finite_and_not_negative_for_any_length_and_speed(
    kind: str, parameters: dict[str, float]
) -> None:
    bench = Bench((kind, parameters))
    low, high = bench.laws.command_low[0], min(bench.laws.command_high[0], 1e6)
    for length in ABSURD:
        for speed in (0.0, *ABSURD, *(-v for v in ABSURD)):
            for command in (low, high, -1e300, 1e300):
                before = bench.start(length, command)
                bench.advance(length, speed, command, 1e-3)
                after = bench.tension(length, speed, command)
                assert 0.0 <= before <= 1e15
                assert 0.0 <= after <= 1e15
                assert np.isfinite(bench.laws.states).all()
                rates = bench.state_rates(length, speed, command, bench.laws.states)
                assert np.isfinite(rates).all()
                reach = bench.laws.reach(1e-3)
                assert reach[0][0] <= reach[1][0]


@pytest.mark.parametrize("kind", [k for k in SOUND if MUSCLE_LAWS[k].states])
def test_extreme_states_give_finite_tensions(kind: str) -> None:
    for parameters in [SOUND[kind]] + ([ELASTIC] if kind.startswith("hill") else []):
        bench = Bench((kind, parameters))
        size = bench.laws.states.size
        for value in (-1e9, -1.0, 0.0, 1e-9, 1.0, 1e9):
            for command in (0.0, 1.0):
                states = np.full(size, value)
                assert math.isfinite(bench.tension(0.3, 0.1, command, states))
                bench.advance(0.3, 0.1, command, 1e-3)
                assert bench.tension(0.3, 0.1, command) >= 0.0
                assert np.isfinite(bench.laws.states).all()


def _cycle(
    rng: np.random.Generator, mean: float, amplitude: float
) -> tuple[FloatArray, FloatArray]:
    """Return length and rate of a closed path over a period of 1 s, from random harmonics."""
    t = np.arange(20000) / 20000
    length, speed = np.full(t.size, mean), np.zeros(t.size)
    for k in (1, 2, 3):
        a, phase = amplitude / 2 * rng.random(), 2 * math.pi * rng.random()
        length += a * np.sin(2 * math.pi * k * t + phase)
        speed += a * 2 * math.pi * k * np.cos(2 * math.pi * k * t + phase)
    return length, speed


CABLES = [
    ("elastic_cable", {"stiffness": 2e4}),
    ("elastic_cable", {"stiffness": 2e4, "damping": 300.0}),
    ("ligament_blankevoort1991", SOUND["ligament_blankevoort1991"]),
    ("ligament_blankevoort1991", SOUND["ligament_blankevoort1991"] | {"damping_coefficient": 5.0}),
    ("passive_spring", SOUND["passive_spring"]),
]


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "parameters"), CABLES)
def test_passive_cable_generates_no_energy_over_a_closed_path(
    kind: str, parameters: dict[str, float]
) -> None:
    """The work on a slack or taut cable is not negative, and zero without damping."""
    bench, rng = Bench((kind, parameters)), np.random.default_rng(9)
    undamped = not (parameters.get("damping") or parameters.get("damping_coefficient"))
    if kind == "ligament_blankevoort1991" and "damping_coefficient" not in parameters:
        undamped = False
    for _ in range(4):
        length, speed = _cycle(rng, 0.29, 0.03)
        tension = np.array([bench.tension(x, v, 0.29) for x, v in zip(length, speed, strict=True)])
        work, turned = float(np.mean(tension * speed)), float(np.mean(np.abs(tension * speed)))
        if undamped:
            assert abs(work) < 1e-6 * max(turned, 1e-3)
        else:
            assert work >= -1e-9 * turned
            assert work > 0.0
        if kind not in PUSHING:
            rest = 0.29 if kind == "elastic_cable" else 0.28
            assert (tension[length < rest] == 0.0).all()
            assert (tension >= 0.0).all()


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize("kind", [k for k in SOUND if k.startswith("hill")])
@pytest.mark.parametrize("elastic", [1.0, 0.0])
def test_muscle_without_excitation_dissipates_energy(kind: str, elastic: float) -> None:
    """Fibres without activation are springs and dampers and generate no energy."""
    extra = {"elastic_tendon": elastic, "minimum_activation": 0.0}
    bench, rng = Bench((kind, HILL | extra)), np.random.default_rng(4)
    length, speed = _cycle(rng, 0.33, 0.02)
    bench.start(length[0], 0.0)
    h, work, turned = 1.0 / length.size, 0.0, 0.0
    for lap in range(2):  # the first lap converges to the cycle that the second lap repeats
        for x, v in zip(length, speed, strict=True):
            force = bench.tension(x, v, 0.0)
            bench.advance(x, v, 0.0, h)
            if lap:
                work, turned = work + force * v * h, turned + abs(force * v) * h
    assert turned > 0.1
    assert work >= -1e-3 * turned


@pytest.mark.parametrize(("kind", "parameters"), CASES, ids=_ids(CASES))
def test_tension_is_monotonic_in_the_command(kind: str, parameters: dict[str, float]) -> None:
    """The tension increases with the command, except for commanded rest lengths.

    Hill-type muscles are checked up to their maximum shortening velocity, for Thelen's law up to a
    quarter of it.
    """
    law = MUSCLE_LAWS[kind]
    if law.command is None:
        return
    bench = Bench((kind, parameters))
    low, high = bench.laws.command_low[0], min(bench.laws.command_high[0], 2e3)
    commands = np.linspace(low, high if kind not in BY_LENGTH else 0.6, 40)
    fastest = 0.24 if kind == "hill_thelen2003" else 0.9
    for length in (0.22, 0.29, 0.31, 0.36):
        for speed in (-fastest, -0.2, 0.0, 0.2, 0.9):
            bench.start(length, commands[10])
            states, tensions = bench.laws.states.copy(), []
            for command in commands:
                bench.move(length, speed)
                bench.laws.set_states(states)
                bench.laws.advance([command], 1e-3)
                after = length + 1e-3 * speed
                tensions.append(bench.tension(after, speed, command))
            steps = np.diff(tensions) * (-1.0 if kind in BY_LENGTH else 1.0)
            assert steps.min() >= -1e-9 * max(1.0, max(tensions))


def test_states_of_table_and_core_are_equal() -> None:
    for kind, parameters in CASES:
        bench = Bench((kind, parameters))
        muscle = bench.robot.muscles[0]
        assert len(states_of(muscle.model)) == bench.laws.states.size
        assert _law_of(muscle.model).kind == kind
        assert command_range(muscle.model) == (
            bench.laws.command_low[0],
            bench.laws.command_high[0],
        )
