"""Examples of optimal motions, followed in simulations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES

from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.utils.csv_table import read_csv

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


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fast_throw", "reach_around_obstacle"])
def test_hand_follows_the_motion(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At most 1 mm from the motion, and 5 mm with 10 % wrong masses, also after its end."""
    file = tmp_path / "motion.csv"
    code, _, err = CommandLine(capsys)("optimise", EXAMPLES / name, "-o", file)
    assert code == 0, err
    names, rows = read_csv(file, kind="motion", most=100_000)
    motion = dict(zip(names, rows.T, strict=True))
    hand = [name for name in names if name.startswith("y.")]
    for scale, most in ((1.0, 1e-3), (1.1, 5e-3), (0.9, 5e-3)):
        settings = {"reference.file": str(file), "plant.mass_scale": scale}
        own = simulate(Experiment.load(EXAMPLES / name, settings), coupling="direct")
        errors = [own[y] - np.interp(own["time"], motion["time"], motion[y]) for y in hand]
        assert np.linalg.norm(errors, axis=0).max() < most
        assert own.summary["infeasible_ticks"] == 0
    if name == "fast_throw":
        at = np.searchsorted(motion["time"], 0.6 * motion["time"][-1])
        speed = [motion[f"yd.hand.{axis}"][at] for axis in "xyz"]
        assert speed == pytest.approx([4.0, 0.0, 4.0], abs=0.1)
    else:
        y = np.transpose([motion[y] for y in hand])
        least = np.linalg.norm(y - [0.36, -0.35, 0.32], axis=1).min()
        assert least == pytest.approx(0.1, abs=1e-4)
