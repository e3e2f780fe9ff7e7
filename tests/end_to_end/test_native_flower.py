"""The whole flower by native FMUs: C alone against DART and the laws in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from co_simulation import co_simulate
from robots import EXAMPLES

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation import simulate


def test_the_flower_stays_together(tmp_path: Path) -> None:
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm")
    native = co_simulate(experiment, tmp_path, native=True)
    assert native.failure is None
    direct = simulate(experiment, through="direct")
    apart = {}
    for coordinate in experiment.robot.coordinates:
        name = f"q.{coordinate.name}"
        column = native.rows[:, native.names.index(name)]
        apart[name] = float(np.abs(column - direct[name]).max())
    print(f"\nnative and DART apart by {max(apart.values()):.1e} rad")
    assert max(apart.values()) <= 1e-9
