"""[estimator] in experiments: equal results in C and Python, lost estimates, rejected settings."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.hardware.protocol.recording import read_recording
from cardsflow_fmu.models.estimator import make_estimator
from cardsflow_fmu.results.analysis.observable import (
    observability_notes,
    observability_warnings,
    observed_poses,
)
from cardsflow_fmu.results.files import RECORDING_FILE
from cardsflow_fmu.results.report.readings import read_readings
from cardsflow_fmu.results.verdict import problems
from cardsflow_fmu.simulation.run import simulate
from sim_dart.calibration.calibrate import calibrate

UNITS = [
    {"link": "upper_arm_left"},
    {"link": "lower_arm_left", "position": [0.0, 0.0, 0.1], "gyroscope_bias": [0.005, 0.0, 0.0]},
]
SENSORS = {
    "length_resolution": 1e-5,
    "delay": 0.001,
    "seed": 3,
    "tension_noise": 0.1,
    "encoder_resolution": 1e-4,
}
PERIOD = 0.005


def roboy_experiment(duration: float, **estimator: object) -> Experiment:
    """Return an experiment of Roboy's arm with an estimator in the control loop."""
    return Experiment.load(
        EXAMPLES / "roboy_left_arm", {"estimator": estimator, "run.duration": duration}
    )


@pytest.mark.slow
@pytest.mark.native
def test_estimate_from_all_sensors_is_accurate_enough_for_control() -> None:
    experiment = roboy_experiment(0.3, imus=UNITS, sensors=SENSORS, encoder_noise={"joint_1": 1e-3})
    native = simulate(experiment, coupling="direct")
    assert native["valid"].all()
    for name in ("joint_1", "joint_2", "joint_3", "joint_4"):
        error = native[f"q_hat.{name}"] - native[f"q.{name}"]
        assert np.abs(error).max() < 5.0 * native[f"sd.{name}"].max()
    summary = native.summary["estimation"]
    assert summary["valid_share"] == 1.0
    assert 0.8 < summary["innovation"] < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("example", ["hill_arm", "planar_2r", "pneumatic_elbow"])
def test_estimator_supports_all_muscles_and_motors(example: str) -> None:
    settings: dict[str, object] = {"estimator": {"exact_transition": False}, "run.duration": 0.2}
    if example == "planar_2r":
        settings |= {"robot.joints.joint_2.motor": True}
    experiment = Experiment.load(EXAMPLES / example, settings)
    native = simulate(experiment, coupling="direct")
    assert native["valid"].all()
    assert native.summary["status"] == "complete"


def expected_ramp(forces: np.ndarray, valid: np.ndarray, f_min: float, down: float) -> np.ndarray:
    """Return the expected ramp of the forces at ticks without a valid estimate."""
    lost = np.flatnonzero(valid == 0)
    share = np.clip(1.0 - PERIOD / down * np.arange(1, len(lost) + 1), 0.0, 1.0)
    return f_min + share[:, None] * (forces[lost[0] - 1] - f_min)


@pytest.mark.slow
def test_commands_ramp_down_while_the_estimate_is_invalid() -> None:
    """A frozen length is detected, and the forces decrease linearly to f_min."""
    stuck = {"stuck": {"motor0": 1.0, "motor1": 1.0, "motor2": 1.0}}
    experiment = roboy_experiment(
        1.6, exact_transition=False, sensors=stuck, ramp_down=0.1, gate=1000.0
    )
    result = simulate(experiment, coupling="direct")
    ticks = slice(0, len(result.rows) - 1, 5)
    valid = result["valid"][ticks]
    forces = result.columns([f"f.{m.name}" for m in experiment.robot.muscles])[ticks]
    first = int(np.argmin(valid))
    assert valid[:first].all()
    assert 1.0 < first * PERIOD < 1.5
    assert not valid[first : first + 20].any()
    expected = expected_ramp(forces[: first + 20], valid[: first + 20], 10.0, 0.1)
    assert np.allclose(forces[first : first + 20], expected, atol=1e-9)
    assert np.allclose(forces[first + 19], 10.0)
    line = "the estimate was invalid"
    assert any(warning.startswith(line) for warning in result.summary["warnings"])
    summary = {"estimation": result.summary["estimation"] | {"not_converged_share": 0.25}}
    assert "(its horizon did not converge in 25.0%)" in problems(summary)[0]


@pytest.mark.slow
def test_first_measurement_determines_the_first_pose() -> None:
    """The estimator does not use the start pose."""
    result = simulate(
        roboy_experiment(0.2, exact_transition=False, find_start=True, min_tension=0.5),
        coupling="direct",
    )
    assert result["valid"].all()
    assert result["status"][0] == 1.0
    assert np.abs(result["q_hat.joint_1"][0] - result["q.joint_1"][0]) < 5e-3


@pytest.mark.slow
def test_estimator_without_feedback_does_not_change_the_run() -> None:
    """The controller uses the ground truth, so that the run equals a run without estimator."""
    watched = simulate(roboy_experiment(0.1, feedback=False), coupling="direct")
    alone = simulate(
        Experiment.load(EXAMPLES / "roboy_left_arm", {"run.duration": 0.1}), coupling="direct"
    )
    assert np.array_equal(watched["q.joint_2"], alone["q.joint_2"])
    assert "q_hat.joint_2" in watched.names


def test_estimator_settings_are_read_back_unchanged(tmp_path: Path) -> None:
    experiment = roboy_experiment(0.1, imus=UNITS, sensors={"length_offset": {"motor1": 1e-3}})
    data = json.loads(json.dumps(experiment_data(experiment)))
    data["robot"]["path"] = str(experiment.robot_path.resolve())
    file = tmp_path / "experiment.json"
    file.write_text(json.dumps(data))
    again = Experiment.load(file)
    assert again.estimator == experiment.estimator
    assert again.wiring == experiment.wiring
    unused = Experiment.load(EXAMPLES / "roboy_left_arm", {"estimator.use": False})
    assert unused.estimator is None


def test_calibrated_offsets_are_read_from_the_robot_folder(tmp_path: Path) -> None:
    """The experiment and its FMUs contain numbers instead of "calibrated"."""
    shutil.copytree(EXAMPLES / "roboy_left_arm" / "robot", tmp_path / "new")
    settings = {"robot.path": str(tmp_path / "new"), "estimator": {"offset": "calibrated"}}

    def rejection_message() -> str:
        with pytest.raises(InputError) as error:
            Experiment.load(EXAMPLES / "roboy_left_arm", settings)
        return str(error.value)

    assert "calibration.json does not exist" in rejection_message()
    file = tmp_path / "new" / "calibration.json"
    for content, message in (
        ("{", "calibration.json: "),
        ('{"offsets": {}}', "has no offsets; .*muscles.\\*.offset"),
        ('{"offsets": {"biceps": 1e-3}}', "estimator.offset.*no muscle 'biceps'"),
        ('{"offsets": {"motor1": "a"}}', "estimator.offset.motor1: must be a number"),
    ):
        file.write_text(content)
        assert re.search(message, rejection_message())
    file.write_text('{"offsets": {"motor1": 1e-3}}')
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", settings)
    assert experiment.estimator is not None
    assert experiment.estimator.offset == (0.0, 1e-3, *(0.0,) * 9)
    assert experiment_data(experiment)["estimator"]["offset"][1] == 1e-3


@pytest.mark.slow
def test_drifted_offsets_are_offered_as_a_new_calibration(tmp_path: Path) -> None:
    """A length drifts by 1 mm/s. The new file has its offset; the robot's file does not change."""
    robot = tmp_path / "robot"
    shutil.copytree(EXAMPLES / "planar_2r" / "robot", robot)
    old = {
        "offsets": {"cable_1": 0.0},
        "parameters": [
            {"name": "muscles.cable_2.offset", "change": 0.0, "sd": 1.0},
            {"name": "joints.joint_1.damping", "change": 0.1, "sd": 0.2},
        ],
    }
    (robot / "calibration.json").write_text(json.dumps(old))
    drift = {"kind": "length_drift", "part": "cable_2", "time": 0.0, "value": 1e-3}
    settings: dict[str, Any] = {
        "robot.path": str(robot),
        "run.duration": 0.5,
        "run.accept": "any",
        "hardware": {"use": True, "link": "emulated:", "mode": "lockstep"},
        "hardware.emulator": {"noise": 1e-4, "failures": [drift]},
        "estimator": {"encoder_noise": 1e-4, "acceleration_noise": 5.0, "offset_drift": 1e-3},
        "faults": {},
    }
    experiment = Experiment.load(EXAMPLES / "planar_2r", settings)
    result = run(experiment, tmp_path / "out", coupling="direct")
    assert "faults" not in result.summary
    row = result.summary["estimation"]["offsets"]["cable_2"]
    assert row["observed"]
    assert abs(row["end"] - 0.5e-3) < 4.0 * row["sd"] < 0.3e-3
    (line,) = [w for w in result.summary["warnings"] if w.startswith("length offsets have changed")]
    assert "cable_2 by 0." in line
    new = json.loads((tmp_path / "out" / "calibration_updated.json").read_text())
    assert new["offsets"]["cable_2"] == row["end"]
    assert new["parameters"] == [
        {"name": "muscles.cable_2.offset", "change": row["end"], "sd": row["sd"]},
        old["parameters"][1],
    ]
    assert json.loads((robot / "calibration.json").read_text()) == old
    shutil.copy(tmp_path / "out" / "calibration_updated.json", robot / "calibration.json")
    again = Experiment.load(EXAMPLES / "planar_2r", settings | {"estimator.offset": "calibrated"})
    assert again.estimator is not None
    assert again.estimator.offset is not None
    assert again.estimator.offset[1] == row["end"]


@pytest.mark.slow
def test_unobservable_poses_are_reported_before_a_run() -> None:
    """Without the lengths of the elbow muscles, joint_4 is unobservable at all poses."""
    found = observed_poses(roboy_experiment(0.1))
    assert not observability_warnings(found)
    assert set(found["critical"]) == {"motor9", "motor10"}
    assert any("motor10 and motor9" in line for line in observability_notes(found))
    blind = roboy_experiment(0.1, length_noise={"motor9": 0.0, "motor10": 0.0, "*": 1e-4})
    (line,) = observability_warnings(observed_poses(blind))
    assert "joint_4 at 33 of 33 poses" in line
    helped = roboy_experiment(
        0.1,
        length_noise={"motor9": 0.0, "motor10": 0.0, "*": 1e-4},
        encoder_noise={"joint_4": 1e-3},
    )
    assert not observability_warnings(observed_poses(helped))
    assert line in simulate(blind, coupling="direct").summary["warnings"]
    (line,) = observability_warnings(observed_poses(roboy_experiment(0.1, offset_drift=1e-5)))
    assert "rank 0 of 4" in line
    for settings in ({"encoder_noise": 0.01}, {"offset_drift": {"motor2": 1e-5, "motor9": 1e-5}}):
        known = roboy_experiment(0.1, **{"offset_drift": 1e-5} | settings)
        assert not observability_warnings(observed_poses(known))


@pytest.mark.slow
def test_hardware_without_joint_encoders_only_sends_lengths_and_tensions(tmp_path: Path) -> None:
    """The estimate stays near the pose that matches the lengths; its error is unknown."""
    settings = {"use": True, "mode": "lockstep", "link": "loopback:", "has_positions": False}
    settings["emulator"] = {"noise": 1e-4}
    own = {"estimator": {"find_start": True}, "hardware": settings, "run.duration": 0.1}
    experiment = Experiment.load(EXAMPLES / "roboy_left_arm", own)
    result = run(experiment, tmp_path / "out", compute="python", coupling="direct")
    header = read_recording(tmp_path / "out" / RECORDING_FILE).header
    assert {name.partition(".")[0] for name in header.state_names} == {"l", "tension"}
    assert result["valid"].all()
    for c in experiment.robot.coordinates:
        off = result[f"q.{c.name}"] - result[f"q_hat.{c.name}"]
        assert 0 < np.sqrt(np.mean(off**2)) < 0.02
    estimation = result.summary["estimation"]
    assert (estimation["per_signal"], estimation["fitted"]) == ({}, True)
    with pytest.raises(InputError, match="muscle lengths are not sufficient"):
        calibrate(experiment.robot, [read_readings(tmp_path / "out", experiment.robot)], ["*"])


@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize("settings", [{"type": "horizon"}, {"offset_drift": {"motor1": 1e-3}}])
def test_estimator_fmu_is_bit_identical_to_calls_from_python(settings: dict[str, object]) -> None:
    """FMPy runs estimator.fmu; the same measurements are then written to a `PoseEstimator`."""
    experiment = roboy_experiment(
        0.1, imus=UNITS, sensors={"seed": 3}, encoder_noise={"joint_1": 1e-3}, **settings
    )
    result = simulate(experiment, coupling="fmu")
    robot, estimator = experiment.robot, make_estimator(experiment)
    links = [str(unit["link"]) for unit in UNITS]
    columns = {
        "lengths": [f"l_m.{muscle.name}" for muscle in robot.muscles],
        "tensions": [f"tension_m.{muscle.name}" for muscle in robot.muscles],
        "gyroscope": [f"gyroscope.{link}.{axis}" for link in links for axis in "xyz"],
        "accelerometer": [f"accelerometer.{link}.{axis}" for link in links for axis in "xyz"],
    }
    read = {name: result.columns(names) for name, names in columns.items()}
    estimates = result.columns([f"q_hat.{c.name}" for c in robot.coordinates])
    for k in range(len(estimates) - 1):
        for name, values in read.items():
            getattr(estimator, name).ravel()[:] = values[k]
        estimator.encoders[0] = result["q_m.joint_1"][k]
        if not k:
            estimator.accelerometer[:] = np.nan
        estimator.tick(experiment.run.step, int(k > 0))
        assert np.array_equal(estimates[k], estimator.q), k
        if len(estimator.offset_changes):
            assert result["offset_hat.motor1"][k] == estimator.offset_changes[1]
            assert result["offset_sd.motor1"][k] == estimator.sd[-10]
    assert result["valid"].all()
    assert estimator.used == 11 + 1 + 12
    assert all(estimator.offset_changes[1:2])
