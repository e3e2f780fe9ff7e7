"""Studies with an emulated robot and faulty communication in virtual time; not with a real one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.cases import LONG
from support.small_studies import PLANAR, run_here, small_study

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, Result
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.simulation.run import simulate

EMULATED = """
[settings]
hardware.use = true
hardware.link = "emulated:"
run.duration = 0.2
"""
FAULTS = """
[[vary]]
path = "hardware.emulator.seed"
seed = true
[[vary]]
path = "hardware.emulator.loss"
uniform = [0.0, 0.2]
[[vary]]
path = "hardware.emulator.delay"
uniform = [0.0, 0.0005]
[[vary]]
path = "hardware.emulator.noise"
loguniform = [1e-7, 1e-5]
[[vary]]
path = "muscles.*.f_min"
together = true
values = [5.0, 20.0]
"""
TOP = "count = 6\nmetrics = ['tracking.rms', 'force.low', 'missed']"


def emulated(**faults: object) -> Result:
    settings = {f"hardware.emulator.{name}": value for name, value in faults.items()}
    always = {"hardware.use": True, "hardware.link": "emulated:", "run.duration": 0.5}
    return simulate(Experiment.load(PLANAR, always | settings), coupling="direct")


@pytest.mark.slow
def test_runs_with_an_emulated_robot_are_reproducible() -> None:
    one, again = (emulated(loss=0.2, jitter=1e-3, noise=1e-6, seed=5) for _ in range(2))
    other = emulated(loss=0.2, jitter=1e-3, noise=1e-6, seed=6)
    assert np.array_equal(one.rows, again.rows, equal_nan=True)
    assert not np.array_equal(one.rows, other.rows, equal_nan=True)


@pytest.mark.slow
def test_emulated_hardware_runs_in_virtual_time() -> None:
    summary = emulated().summary
    assert "real_time" not in summary
    assert summary["hardware"]["missed"] == 0


@pytest.mark.slow
def test_packet_loss_equals_the_share_of_missed_exchanges() -> None:
    """A fraction (1 - p)² of 500 exchanges is answered; without a delay no answer is late."""
    loss = 0.1
    missed = emulated(loss=loss, seed=2).summary["hardware"]["missed"]
    expected = 500 * (1.0 - (1.0 - loss) ** 2)
    assert abs(missed - expected) < 4.0 * np.sqrt(expected)


@pytest.mark.slow
def test_the_round_trip_is_twice_the_delay() -> None:
    report = emulated(delay=2e-4).summary["hardware"]
    assert report["round_trip"]["median"] == pytest.approx(4e-4, abs=1e-8)
    assert report["missed"] == 0


@pytest.mark.slow
def test_encoders_quantise_positions() -> None:
    q = emulated(joint_counts=1000.0)["q.joint_1"]
    assert np.allclose(q * 1000.0, np.round(q * 1000.0), rtol=0, atol=1e-9)


@pytest.mark.slow
def test_a_long_outage_stops_the_run() -> None:
    with pytest.raises(Exception, match="the hardware does not respond"):
        emulated(outages=[[0.2, 0.1]])


@LONG
@pytest.mark.slow
def test_faults_are_varied(tmp_path: Path) -> None:
    result = run_here(small_study(tmp_path, FAULTS, TOP, EMULATED), tmp_path / "out")
    assert result.summary["complete"] == 6
    rows = [outcome.metrics for _, outcome in result.rows()]
    assert len({row["missed"] for row in rows}) > 1
    assert {round(row["force.low"]) for row in rows} == {5, 20}


@pytest.mark.slow
def test_a_study_with_a_real_robot_is_rejected(tmp_path: Path) -> None:
    driven = "[settings]\nhardware.use = true\nhardware.link = 'udp://127.0.0.1:5005'\n"
    with pytest.raises(InputError, match="must be false in a study"):
        small_study(tmp_path, short=driven)
    text = "[[vary]]\npath = 'hardware.use'\nvalues = [false, true]\n"
    driven = "[settings]\nhardware.link = 'udp://127.0.0.1:5005'\nrun.duration = 0.01\n"
    result = run_here(small_study(tmp_path, text, "", driven))
    (_, off), (_, on) = result.rows()
    assert off.complete
    assert "must be false in a study" in str(on.error)


@pytest.mark.slow
def test_the_command_line_drives_an_emulated_robot(tmp_path: Path) -> None:
    tables = []
    for k in range(2):
        output = tmp_path / str(k)
        words = ["run", str(PLANAR), "--hardware", "emulated:", "-o", str(output)]
        words += ["--set", "run.duration=0.1", "--set", "hardware.emulator.loss=0.1"]
        assert main(words) == 0
        tables.append((output / "results.csv").read_bytes())
        assert (output / "hardware.rec").stat().st_size > 1000
    assert tables[0] == tables[1]
