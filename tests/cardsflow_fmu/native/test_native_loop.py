"""The loop in C: batches, failures, summaries, and rejected experiments."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.models.native_loop import native_loop
from cardsflow_fmu.simulation.run import RunError, run, simulate

pytestmark = pytest.mark.native

SHORT = {"planar_2r": {"run.duration": 0.4}, "roboy_left_arm": {"run.duration": 0.2}}


def load(example: str, settings: dict[str, Any] | None = None) -> Experiment:
    return Experiment.load(EXAMPLES / example, SHORT[example] | (settings or {}))


def recorded(experiment: Experiment) -> Recording:
    return native_loop(experiment).run()


def test_runs_in_threads_equal_single_runs() -> None:
    experiments = [load("planar_2r", {"controller.kp": 900.0 + 100.0 * k}) for k in range(4)]
    with ThreadPoolExecutor(2) as pool:
        batch = list(pool.map(recorded, experiments))
    for experiment, recording in zip(experiments, batch, strict=True):
        np.testing.assert_array_equal(recording.rows, recorded(experiment).rows)
    assert not np.array_equal(batch[0].rows, batch[1].rows)


def test_failed_run_keeps_its_rows(tmp_path: Path) -> None:
    """An overflowing force: the rows before the failure equal those of Python objects."""
    force = {"force": {"tip": [1e308, 1e308, 1e308]}, "begin": 0.05}
    experiment = load("planar_2r", {"disturbance": force})
    found: dict[str, Result] = {}
    for through in ("direct", "native"):
        with pytest.raises(RunError, match="diverged at t ="):
            simulate(experiment, **RUN_MODES[through])
        with pytest.raises(RunError) as caught:
            run(experiment, tmp_path / through, **RUN_MODES[through])
        found[through] = caught.value.result
        assert found[through].summary["status"] == "incomplete"
        assert (tmp_path / through / "results.csv").is_file()
    assert len(found["native"].rows) == len(found["direct"].rows) == 51


@pytest.mark.slow
def test_summary_has_engine_master_and_speed(tmp_path: Path) -> None:
    experiment = load("planar_2r")
    result = run(experiment, tmp_path / "out", coupling="direct")
    assert result.summary["engine"] == {"plant": "native", "controller": "native"}
    assert result.summary["master"] == "C"
    assert result.summary["real_time_factor"] > 0
    assert "engine      plant native, controller native; master C" in result.describe()
    direct = simulate(
        load("planar_2r", {"plant.engine": "dart"}), compute="python", coupling="direct"
    )
    assert direct.summary["engine"] == {"plant": "dart", "controller": "core"}
    assert direct.summary["master"] == "C, over objects"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"controller.solver": "daqp"}, "the QP solver 'daqp'"),
        ({"plant.engine": "dart"}, r'the engine "dart" \(plant\.engine\)'),
        ({"controller.engine": "dart"}, r'the engine "dart" \(controller\.engine\)'),
        ({"world": {"ground": {}}}, "worlds with contacts"),
    ],
)
def test_unsupported_settings_are_reported_by_name(settings: dict[str, Any], message: str) -> None:
    experiment = load("planar_2r", settings | {"run.duration": 0.01})
    summary = simulate(experiment, coupling="direct").summary
    assert summary["master"] == "C, over objects"
    assert re.search(message, summary["not_in_c"]["loop"])


def test_real_time_uses_the_loop() -> None:
    experiment = load("planar_2r", {"run.duration": 0.01})
    paced = simulate(experiment, coupling="direct", realtime=True)
    assert paced.summary["master"] == "C"
    assert paced.summary["real_time"]["steps"] == 11
    np.testing.assert_array_equal(paced.rows, simulate(experiment, coupling="direct").rows)


@pytest.mark.parametrize("key", ["plant.engine", "controller.engine"])
def test_unknown_and_unsupported_engines_are_rejected(key: str) -> None:
    with pytest.raises(InputError, match=rf"{key}: no engine 'cor'; did you mean 'core'"):
        load("planar_2r", {key: "cor"})
    with pytest.raises(InputError, match=r'plant.engine: "core" does not support contacts.*"dart"'):
        load("planar_2r", {"plant.engine": "core", "world": {"ground": {}}})
    experiment = load("planar_2r", {key: "dart"})
    part = key.partition(".")[0]
    assert experiment_data(experiment)[part]["engine"] == "dart"


@pytest.mark.slow
def test_engines_agree() -> None:
    """All four pairs of engines, in the same closed loop."""
    rows = []
    for plant in ("core", "dart"):
        for controller in ("core", "dart"):
            settings = {"plant.engine": plant, "controller.engine": controller}
            rows.append(
                simulate(load("roboy_left_arm", settings), compute="python", coupling="direct")
            )
    names = [f"q.{c.name}" for c in rows[0].experiment.robot.coordinates]
    for other in rows[1:]:
        for name in names:
            np.testing.assert_allclose(other[name], rows[0][name], rtol=0, atol=1e-12)
