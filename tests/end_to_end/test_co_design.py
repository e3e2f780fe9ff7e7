"""Attachment points and motion of examples/co_design, simulated with the written robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from cardsflow_fmu.simulation.run import simulate

CO_DESIGN = EXAMPLES / "co_design"


def _effort(result: Result) -> float:
    """Return ∫ f² dt, in [N² s]."""
    assert result.summary["infeasible_ticks"] == 0
    forces = [result[f"f.cable_{k}"] for k in (1, 2, 3, 4)]
    return float(np.trapezoid(np.sum(np.square(forces), axis=0), result["time"]))


@pytest.mark.slow
def test_written_robot_needs_less_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The figures of the README; without free points, the motion itself needs 530 N² s."""
    code, _, err = CommandLine(capsys)("optimise", CO_DESIGN, "-o", tmp_path / "found.csv")
    assert code == 0, err
    own = Experiment.load(tmp_path / "found_robot" / "experiment.json")
    assert _effort(simulate(own, coupling="direct")) == pytest.approx(451.0, abs=2.0)
    published = optimise(load_for_motion(CO_DESIGN, {"motion.parameters": []}))
    assert published.solution.cost == pytest.approx(530.0, abs=2.0)
