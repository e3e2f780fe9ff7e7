"""Failures of cables, motors and sensors of an emulated robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, run
from cardsflow_fmu.experiment.settings.hardware import EmulatorSettings
from cardsflow_fmu.hardware.emulator.emulator import EmulatedRobot
from cardsflow_fmu.models.estimator import EstimatorModel
from cardsflow_fmu.simulation.run import simulate
from sim_dart import CoreDynamics

STEP = 1e-3
TIME = 0.05


def emulated(*failures: dict[str, Any]) -> EmulatedRobot:
    rows = tuple({"part": "cable_1", "time": TIME} | each for each in failures)
    settings = EmulatorSettings(failures=rows)
    return EmulatedRobot(planar_2r(), STEP, q=[0.1, 0.2], emulator=settings)


def states(robot: EmulatedRobot, steps: int = 100) -> np.ndarray:
    """Return q, qd, l and tensions over time, shape (steps, 2 + 2 + 4 + 4)."""
    rows = []
    for k in range(steps):
        robot.apply(np.array([40.0, 20.0, 30.0, 10.0]) + 5.0 * np.sin(0.1 * k))
        robot.advance(STEP)
        rows.append(robot.state())
    return np.array(rows)


def test_states_are_equal_until_the_failure() -> None:
    intact = states(emulated())
    kinds = [("broken", {}), ("jammed", {"value": 1e4}), ("weak", {"value": 0.5})]
    for kind, more in kinds:
        failed = states(emulated({"kind": kind, **more}))
        np.testing.assert_array_equal(failed[:50], intact[:50])
        assert np.abs(failed[99, :2] - intact[99, :2]).max() > 1e-4, kind


def test_motor_failures_change_the_tension() -> None:
    broken = states(emulated({"kind": "broken"}))
    assert (broken[50:, 8] == 0.0).all()
    assert (broken[50:, 4] == broken[50, 4]).all()
    weak = states(emulated({"kind": "weak", "value": 0.25}))
    intact = states(emulated())
    assert weak[51:, 8] == pytest.approx(0.25 * intact[51:, 8])
    robot = emulated({"kind": "jammed", "value": 1e4})
    jammed = states(robot)
    assert np.ptp(jammed[50:, 4]) == 0.0
    robot.plant.reset(jammed[-2, :2])  # the force of the last step
    expected = jammed[50, 8] + 1e4 * (robot.plant.muscle_lengths[0] - jammed[50, 4])
    assert jammed[-1, 8] == pytest.approx(max(expected, 0.0), abs=1e-9)


def test_sensor_failures_do_not_change_the_motion() -> None:
    intact = states(emulated())
    length, other, tension = intact[:, 4], intact[:, 6], intact[:, 8]
    assert np.ptp(tension[50:]) > 1.0
    expected = {
        "length_stuck": ({}, 4, np.full(50, length[49])),
        "length_bias": ({"value": 0.01}, 4, length[50:] + 0.01),
        "length_drift": ({"value": 0.4}, 4, length[50:] + 4e-4 * np.arange(1, 51)),
        "off_pulley": ({"value": -0.02}, 4, length[50:] - 0.02),
        "length_scale": ({"value": 1.1}, 4, length[49] + 1.1 * (length[50:] - length[49])),
        "length_swapped": ({"other": "cable_3"}, 4, other[50:]),
        "tension_stuck": ({}, 8, np.full(50, tension[49])),
        "tension_dead": ({}, 8, np.zeros(50)),
        "encoder_stuck": ({"part": "joint_1"}, 0, np.full(50, intact[49, 0])),
    }
    for kind, (more, column, values) in expected.items():
        failed = states(emulated({"kind": kind, **more}))
        assert failed[50:, column] == pytest.approx(values, abs=1e-12), kind
        same = np.delete(failed, [column, 2, 6], axis=1)
        np.testing.assert_array_equal(same, np.delete(intact, [column, 2, 6], axis=1))


def test_reset_repeats_the_failures() -> None:
    robot = emulated({"kind": "length_stuck"}, {"kind": "jammed", "value": 1e4})
    first = states(robot)
    robot.reset()
    np.testing.assert_array_equal(states(robot), first)


def test_failure_of_the_emulated_device_is_found_by_fmus_and_models_alike(tmp_path: Path) -> None:
    settings = {
        "run.duration": 0.4,
        "run.accept": "any",
        "hardware.link": "emulated:",
        "hardware.use": True,
        "hardware.emulator": {"noise": 1e-4, "tension_noise": 0.05},
        "hardware.emulator.failures": [{"kind": "broken", "part": "cable_2", "time": 0.3}],
        "estimator": {"encoder_noise": 1e-4},
        "faults": {"tension_noise": 0.1},
    }
    experiment = Experiment.load(PLANAR_2R, settings)
    result = run(experiment, tmp_path)
    tension, time = result["tension.cable_2"], result["time"]
    assert (tension[time <= 0.29] > 0.0).all()
    assert (tension[time >= 0.32] == 0.0).all()
    found = time[result["fault.cable_2"] == 1.0]
    assert 0.3 <= found[0] <= 0.33
    assert result["faults"].max() == 1.0
    assert result["bound.cable_2"][-1] == 0.0
    assert result["bound.cable_1"][-1] == experiment.robot.muscles[0].f_max
    direct = simulate(experiment, coupling="direct")
    for name in ("fault.cable_2", "fault_statistic", "bound.cable_2", "w_hat.joint_1"):
        assert (direct[name] == result[name]).all()


def test_faulty_sensor_stays_unused_if_no_other_sensor_measures() -> None:
    """The pose of the monitor is then unknown."""
    settings = {
        "estimator": {"encoder_noise": 1e-4, "length_noise": 1e-4, "gate": 1e6},
        "faults": {"length_error": 0.0},
    }
    experiment = Experiment.load(PLANAR_2R, settings)
    model, random = EstimatorModel(experiment), np.random.default_rng(0)
    at = {port.name: k for k, port in enumerate(model.ports)}
    poses, lengths = [at["q.joint_1"], at["q.joint_2"]], [at[f"l.cable_{k}"] for k in (1, 2, 3, 4)]
    rest = np.array(experiment.start.q)
    expected = np.concatenate([CoreDynamics(experiment.robot).muscle_lengths(rest), rest])
    model.initialize()
    model.values[[at[f"tension.cable_{k}"] for k in (1, 2, 3, 4)]] = 20.0  # not slack
    model.values[[at[f"f.cable_{k}"] for k in (1, 2, 3, 4)]] = 20.0
    for k in range(200):
        if k == 100:
            expected[0] += 5e-3
        if k == 150:
            expected[1:] = np.nan
        model.values[[*lengths, *poses]] = expected + 1e-4 * random.standard_normal(6)
        model.step(k * STEP, STEP)
    assert model.values[at["length_fault.cable_1"]] == 5.0
    assert model.values[at["readings"]] == 0.0


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("broken", "must be KIND:NAME[=VALUE]@TIME, such as broken:motor3@2.0"),
        ("broken:cable_1@soon", "must have numbers in 'broken:cable_1@soon'"),
        ("broken:cable_9@1", "no muscle 'cable_9'; did you mean"),
        ("encoder_stuck:cable_1@1", "no coordinate 'cable_1'"),
        ("burnt:cable_1@1", "no kind 'burnt'; did you mean 'broken'?"),
        ("weak:cable_1@1", "failures[0].value: missing; it is required for kind 'weak'"),
        ("broken:cable_1=2@1", "failures[0].value: is unused for kind 'broken'"),
        ("length_swapped:cable_1@1", "failures[0].other: missing; it is required"),
        ("broken:cable_1@-1", "failures[0].time"),
    ],
)
def test_invalid_failure_is_rejected_in_one_line(
    fault: str, message: str, cardsflow: CommandLine
) -> None:
    words = ["--listen", "udp://127.0.0.1:0", "--duration", "0.01", "--fault", fault]
    assert message in cardsflow.error_line("device", PLANAR_2R, *words)


def test_unknown_part_of_an_experiment_is_rejected() -> None:
    with pytest.raises(InputError, match=r"hardware.emulator.failures\[0\]: no muscle 'cable_7'"):
        emulated({"kind": "broken", "part": "cable_7"})
