"""Complete or shortened studies of examples/design_study."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from support.cases import LONG
from support.small_studies import PLANAR, ROOT

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.studies import Study, run_study

pytestmark = LONG
STUDIES = ROOT / "examples" / "design_study"


def test_optimised_attachments_need_less_than_70_percent_of_the_peak_force(tmp_path: Path) -> None:
    """This holds for all three searches, and for the written robot at the paper's rate."""
    published = simulate(Experiment.load(PLANAR), coupling="direct").summary["forces"]["max"]
    result = run_study(Study.load(STUDIES / "attachments.toml"), jobs=2, output=tmp_path / "out")
    ends = [history[-1] for history in result.summary["history"].values()]
    assert len(ends) == 3
    assert max(ends) <= 0.7 * published
    settings = {"controller.period": 1e-3, "run.step": 1e-3, "plant.step": 1e-3}
    written = Experiment.load(tmp_path / "out" / "best" / "experiment.json", settings)
    summary = simulate(written).summary
    assert summary["forces"]["max"] <= 0.7 * published
    assert summary["infeasible_ticks"] == 0


def test_the_flower_tolerates_unknown_masses(tmp_path: Path) -> None:
    study = replace(Study.load(STUDIES / "flower"), count=8)
    result = run_study(study, jobs=2, output=tmp_path / "out")
    assert result.summary["complete"] == 8
    assert result.summary["metrics"]["tracking.max"]["max"] < 0.02
