"""Reachable tensions, and commands for desired tensions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, SOUND, Bench

from addin_sdfusion.robot.model.laws import MUSCLE_LAWS

pytestmark = pytest.mark.native

ELASTIC = HILL | {"elastic_tendon": 1.0}
DRIVEN = [
    *((kind, p) for kind, p in SOUND.items() if MUSCLE_LAWS[kind].command and kind != "ideal"),
    *((kind, ELASTIC) for kind in SOUND if kind.startswith("hill")),
]


def _predicted_tension(
    bench: Bench, length: float, speed: float, command: float, h: float
) -> float:
    """Return the tension that `reach` predicts: after a step, or immediately without states."""
    if not bench.laws.states.size:
        return bench.tension(length, speed, command)
    before = bench.laws.states.copy()
    bench.advance(length, speed, command, h)
    tension = bench.tension(length + speed * h, speed, command)
    bench.laws.set_states(before)
    bench.move(length, speed)
    return tension


@pytest.mark.parametrize(("kind", "parameters"), DRIVEN)
@pytest.mark.parametrize("h", [1e-3, 0.02])
def test_commands_lead_to_the_desired_tension(
    kind: str, parameters: dict[str, float], h: float
) -> None:
    """Desired tensions are reached to 1e-9 of the range. Outside of it the nearest end is used."""
    bench = Bench((kind, parameters))
    for length, speed in ((0.3, 0.0), (0.32, -0.3), (0.28, 0.4), (0.31, 0.05)):
        bench.start(length, 0.3 * min(bench.laws.command_high[0], 1.0))
        bench.move(length, speed)
        low, high = (float(side[0]) for side in bench.laws.reach(h))
        ends = [_predicted_tension(bench, length, speed, u, h) for u in command_range(bench)]
        assert (low, high) == pytest.approx((min(ends), max(ends)), rel=1e-12, abs=1e-12)
        for part in (0.0, 0.01, 0.3, 0.7, 0.99, 1.0):
            desired = low + part * (high - low)
            command = float(bench.laws.invert([desired], h)[0])
            assert bench.laws.command_low[0] <= command <= bench.laws.command_high[0]
            found = _predicted_tension(bench, length, speed, command, h)
            assert found == pytest.approx(desired, abs=1e-9 * max(high, 1e-3))
        if low < high:
            for desired, end in ((high + 50.0, high), (low - 50.0, low)):
                command = float(bench.laws.invert([desired], h)[0])
                assert _predicted_tension(bench, length, speed, command, h) == pytest.approx(
                    end, rel=1e-9
                )


def command_range(bench: Bench) -> tuple[float, float]:
    """Return the smallest and the largest command."""
    return float(bench.laws.command_low[0]), float(bench.laws.command_high[0])


def test_reach_of_ideal_and_passive_muscles() -> None:
    spring = ("passive_spring", {"K": 100.0, "l0": 0.2})
    bench = Bench(("ideal", {}), spring, ("ligament_blankevoort1991", SOUND[LIGAMENT]))
    bench.move(0.3, 0.1)
    low, high = bench.laws.reach(1e-3)
    tensions = bench.laws.drive([0.1], [0.0, 0.0, 0.0])
    assert (low[0], high[0]) == (0.0, math.inf)
    assert low[1:].tolist() == high[1:].tolist() == tensions[1:].tolist()
    assert bench.laws.invert([40.0, 3.0, 3.0], 1e-3).tolist() == [40.0, 0.0, 0.0]
    assert bench.laws.invert([-40.0, 3.0, 3.0], 1e-3)[0] == 0.0


LIGAMENT = "ligament_blankevoort1991"


def test_reach_and_inversion_do_not_change_states() -> None:
    bench = Bench(*SOUND.items())
    bench.move(0.3, 0.05)
    bench.laws.start(np.full(len(SOUND), 0.3))
    before = bench.laws.states.copy()
    bench.laws.reach(1e-3)
    bench.laws.invert(np.full(len(SOUND), 20.0), 1e-3)
    np.testing.assert_array_equal(bench.laws.states, before)


@pytest.mark.parametrize(("kind", "parameters"), DRIVEN)
def test_commands_do_not_depend_on_earlier_calls(kind: str, parameters: dict[str, float]) -> None:
    """Results are bit-identical after calls at another length, speed, time and state."""
    here = {"length": 0.3, "speed": 0.05, "state": 0.2, "h": 1e-3}
    others = [here, *(here | {key: 1.1 * value} for key, value in here.items())]
    found = []
    for before in (None, *others):
        bench = Bench((kind, parameters))
        for at in (here,) if before is None else (before, here):
            bench.start(0.3, at["state"] * min(float(bench.laws.command_high[0]), 1.0))
            bench.move(at["length"], at["speed"])
            if at is before:
                bench.laws.reach(at["h"])
        found.append(float(bench.laws.invert([20.0], here["h"])[0]))
    assert len(set(found)) == 1
