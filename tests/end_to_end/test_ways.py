"""Who computes and how models are coupled changes nothing; no hardware in a plain run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from support.cases import few
from support.fmu.co_simulation import assert_rows_agree
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.ways import WAYS

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.run import simulate

EXAMPLE = few(["planar_2r", "pick_up", "hill_arm", "cable_robot"])


@pytest.mark.parametrize("example", EXAMPLE)
def test_every_way_gives_the_same_columns(example: str) -> None:
    experiment = Experiment.load(EXAMPLES / example, {"run.duration": 0.05})
    first, *others = (simulate(experiment, **way) for way in WAYS.values())
    for other in others:
        assert other.units == first.units
        assert_rows_agree(other, first, forces=1e-9, others=1e-9)


PLAIN = """
import sys
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.results.report import run_figures
run_figures.image = lambda figure, form, mark: b""  # drawing takes longer than all else
assert main(["run", {example!r}, "--set", "run.duration=0.02", "-o", {folder!r}]) == 0
print([name for name in sys.modules if name.startswith("cardsflow_fmu.hardware")])
"""


def test_a_run_without_hardware_imports_nothing_of_it(tmp_path: Path) -> None:
    script = PLAIN.format(example=str(PLANAR_2R), folder=str(tmp_path / "out"))
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
