"""Attachment points and motion of examples/co_design, simulated with the written robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.run import simulate

CO_DESIGN = EXAMPLES / "co_design"


def _effort(result: Result) -> float:
    """Return ∫ f² dt, in [N² s]."""
    assert result.summary["infeasible_ticks"] == 0
    forces = [result[f"f.cable_{k}"] for k in (1, 2, 3, 4)]
    return float(np.trapezoid(np.sum(np.square(forces), axis=0), result["time"]))


@pytest.mark.slow
def test_written_robot_needs_less_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The figures of the README."""
    cardsflow, motions = CommandLine(capsys), {}
    for name, settings in (("found", []), ("published", ["--set", "motion.parameters=[]"])):
        motions[name] = tmp_path / f"{name}.csv"
        code, _, err = cardsflow("optimise", CO_DESIGN, *settings, "-o", motions[name])
        assert code == 0, err
    assert not (tmp_path / "published_robot").exists()
    own = Experiment.load(tmp_path / "found_robot" / "experiment.json")
    found = _effort(simulate(own, coupling="direct"))
    reference = {"type": "optimised", "file": str(motions["published"])}
    old = Experiment.load(CO_DESIGN, {"reference": reference})
    published = _effort(simulate(old, coupling="direct"))
    assert found == pytest.approx(451.0, abs=2.0)
    assert published == pytest.approx(527.0, abs=2.0)
