"""The whole flower, 30 s and the way to it: C alone against DART and the laws in Python."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.cases import LONG
from support.fmu.co_simulation import co_simulate
from support.robots.robots import EXAMPLES
from support.ways import WAYS

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate

NEAR = 1e-9  # in [rad]


def apart(found: Callable[[str], np.ndarray], reference: Result) -> float:
    """The largest difference of a joint position, in [rad]."""
    names = [f"q.{coordinate.name}" for coordinate in reference.experiment.robot.coordinates]
    return max(float(np.abs(found(name) - reference[name]).max()) for name in names)


@LONG
@pytest.mark.slow
def test_the_flower_stays_together(tmp_path: Path) -> None:
    arm = EXAMPLES / "roboy_left_arm"
    experiment = Experiment.load(arm)
    in_dart = {"plant.engine": "dart", "controller.engine": "dart"}
    dart = simulate(Experiment.load(arm, in_dart), compute="python", coupling="direct")
    assert dart["time"][-1] >= 30.0
    core, loop = (simulate(experiment, **WAYS[way]) for way in ("direct", "native"))
    fmus = co_simulate(experiment, tmp_path, compute="c")
    assert fmus.failure is None
    np.testing.assert_array_equal(loop.rows, fmus.rows)
    off = {"core": apart(core.__getitem__, dart), "loop in C": apart(loop.__getitem__, dart)}
    print("\nfrom DART: " + ", ".join(f"{name} {by:.1e} rad" for name, by in off.items()))
    assert max(off.values()) <= NEAR
