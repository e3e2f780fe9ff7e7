"""Compare the loop in C with DART for the complete flower, 30 s, and its approach."""

from __future__ import annotations

import numpy as np
import pytest
from support.cases import LONG
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate

NEAR = 1e-9  # in [rad]


def largest_difference(found: Result, reference: Result) -> float:
    """Return the largest difference of a joint position, in [rad]."""
    names = [f"q.{coordinate.name}" for coordinate in reference.experiment.robot.coordinates]
    return max(float(np.abs(found[name] - reference[name]).max()) for name in names)


@LONG
@pytest.mark.slow
def test_flower_in_c_matches_dart() -> None:
    arm = EXAMPLES / "roboy_left_arm"
    experiment = Experiment.load(arm)
    in_dart = {"plant.engine": "dart", "controller.engine": "dart"}
    dart = simulate(Experiment.load(arm, in_dart), coupling="direct")
    assert dart["time"][-1] >= 30.0
    off = largest_difference(simulate(experiment, coupling="direct"), dart)
    print(f"\nfrom DART: {off:.1e} rad")
    assert off <= NEAR
