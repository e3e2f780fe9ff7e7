"""Invalid step lengths are rejected immediately by Python and native FMUs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from support.fmu.fmu_host import require_error, running
from support.robots.robots import PLANAR_2R
from support.run_modes import COMPUTE

from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build

pytestmark = pytest.mark.native

NO_STEP = (0.0, -1e-3, math.nan, math.inf, -math.inf)
REASONS = {"plant": "the plant's internal step", "controller": "the controller's period"}


@pytest.fixture(scope="module", params=[True, False], ids=["native", "python"])
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict:
    experiment = Experiment.load(PLANAR_2R, {"run.duration": 0.1})
    folder = tmp_path_factory.mktemp("fmus")
    return build(experiment, folder, compute=COMPUTE[bool(request.param)])


@pytest.mark.parametrize("model", REASONS)
def test_too_long_steps_are_rejected(files: dict[str, Path], model: str, tmp_path: Path) -> None:
    """The message is correct, and the FMU does not try to compute the step."""
    for step in (1e6, 1e300, 100.001):
        with running(files[model], tmp_path / str(step)) as host:
            require_error(lambda host=host, step=step: host.slave.doStep(0.0, step))
            said = f"times {REASONS[model]}, 0.001 s; the maximum is 100000"
            assert said in host.last
            assert "\n" not in host.last


@pytest.mark.parametrize("model", REASONS)
def test_zero_steps_are_rejected(files: dict[str, Path], model: str, tmp_path: Path) -> None:
    for step in NO_STEP:
        with running(files[model], tmp_path / str(step)) as host:
            require_error(lambda host=host, step=step: host.slave.doStep(0.0, step))
            assert host.last == f"doStep: invalid step of {step:.12g} s at 0 s"


def test_reset_restarts_a_dead_worker(files: dict[str, Path], tmp_path: Path) -> None:
    with running(files["plant"], tmp_path / "unpacked") as host:
        require_error(lambda: host.slave.doStep(0.0, 1e6))
        host.slave.reset()
        host.start()
        host.slave.doStep(0.0, 1e-3)
