"""Parallel evaluation of muscles equals the evaluation of single muscles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from support.robots.muscle_bench import HILL, SOUND, Bench

pytestmark = pytest.mark.native

Model = tuple[str, Mapping[str, float]]

LENGTH, SPEED = 0.315, -0.05
STEEP, GENTLE = {"passive_fibre_strain": 0.5}, {"passive_fibre_strain": 0.9}


def mixed_muscles(rng: np.random.Generator, count: int) -> list[Model]:
    """Return muscles of all laws, some repeated, with equal and different curves."""
    others: list[Model] = [(kind, p) for kind, p in SOUND.items() if not kind.startswith("hill")]
    models = []
    for _ in range(count):
        kind = str(rng.choice(["hill_millard2012", "hill_degroote2016", "hill_thelen2003"]))
        shape = STEEP if rng.random() < 0.5 else GENTLE
        elastic = {"elastic_tendon": float(rng.random() < 0.2)}
        own = {
            "max_isometric_force": float(rng.uniform(100, 2000)),
            "activation_time_constant": float(10 ** rng.uniform(-3, -1)),
            "deactivation_time_constant": float(10 ** rng.uniform(-3, -1)),
        }
        if kind == "hill_degroote2016":
            own["activation_smoothing"] = float(rng.choice([0.05, 0.1, 0.5]))
        models += [(kind, HILL | shape | elastic | own)] * int(rng.integers(1, 4))
        if rng.random() < 0.1:
            models.append(others[int(rng.integers(len(others)))])
    return models


def tensions_over_steps(bench: Bench, commands: np.ndarray, h: float) -> np.ndarray:
    """Return tensions over a few steps, one column per muscle."""
    bench.move(LENGTH, SPEED)
    bench.laws.start(commands[0])
    rows = []
    for u in commands:
        rows.append(bench.laws.drive([SPEED], u).copy())
        bench.laws.advance(u, h)
    return np.array(rows)


@pytest.mark.parametrize("h", [1e-4, 1e-3, 2e-2])
def test_parallel_muscles_equal_single_muscles(h: float) -> None:
    """Results are bit-identical for any combination of laws and steps with several parts."""
    rng = np.random.default_rng(4)
    models = mixed_muscles(rng, 30)
    commands = rng.uniform(0, 1, (6, len(models)))
    together = tensions_over_steps(Bench(*models), commands, h)
    for k, model in enumerate(models):
        alone = tensions_over_steps(Bench(model), commands[:, k : k + 1], h)
        np.testing.assert_array_equal(together[:, k], alone[:, 0])


@pytest.mark.parametrize("h", [1e-4, 1e-3, 4e-3, 2e-2])
def test_parallel_activations_equal_single_ones(h: float) -> None:
    """Activations after a step are bit-identical to the prediction of `reach`."""
    rng = np.random.default_rng(5)
    models = [m for m in mixed_muscles(rng, 40) if m[0].startswith("hill")]
    bench = Bench(*models)
    bench.move(LENGTH)
    bench.laws.start(rng.uniform(0, 1, len(models)))
    start = bench.laws.states.copy()
    low, high = (array.copy() for array in bench.laws.reach(h))
    for command, foreseen in ((0.0, low), (1.0, high)):
        u = np.full(len(models), command)
        bench.laws.set_states(start)
        bench.laws.advance(u, h)
        np.testing.assert_array_equal(bench.laws.drive([0.0], u), foreseen)


def test_curves_depend_on_the_parameters_of_each_muscle() -> None:
    """Two of the muscles share their curves. The passive force at its strain is 1 for each."""
    shapes = [STEEP, STEEP, GENTLE, STEEP, STEEP, GENTLE, GENTLE]
    bench = Bench(*(("hill_millard2012", HILL | shape) for shape in shapes))
    for k, shape in enumerate(shapes):
        strained = 1.0 + shape["passive_fibre_strain"]
        (force,) = bench.curve("passive_force_length", [strained], muscle=k)
        assert force == pytest.approx(1.0, abs=1e-12)
