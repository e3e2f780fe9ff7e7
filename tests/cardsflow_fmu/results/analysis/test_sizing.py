"""Sizing of muscles: command and functions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.settings.reference import FlowerSettings
from cardsflow_fmu.models.reference import make_reference
from cardsflow_fmu.results.analysis.sizing import bottlenecks, reference_motion, size, size_robot
from cardsflow_fmu.results.analysis.sizing_report import describe_sizes
from controllers.analysis.inverse_dynamics import Motion, motion_terms, size_muscles
from controllers.force_distribution.linear import minimum_infinity_norm
from sim_dart import DartDynamics

LEFT_ARM = EXAMPLES / "roboy_left_arm"
SLOW = {"controller.period": 0.05}


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return Experiment.load(PLANAR_2R, SLOW)


def test_sized_motion_is_the_reference(experiment: Experiment) -> None:
    motion = reference_motion(experiment)
    assert len(motion.times) == 161
    np.testing.assert_allclose(motion.q[[0, 80, 160]], [[-0.5, 0.5], [0.5, -0.5], [-0.5, 0.5]])
    half = np.gradient(motion.q, motion.times, axis=0)[5:-5]
    np.testing.assert_allclose(motion.qd[5:-5], half, atol=2e-3)


@pytest.mark.slow
def test_required_forces_of_the_planar_arm_match_its_simulation(experiment: Experiment) -> None:
    """41.3 N, as in the closed control loop."""
    sizes = size(experiment, margin=0.5)
    peaks = [row["peak"] for row in sizes["muscles"]]
    assert max(peaks) == pytest.approx(41.3, abs=0.1)
    assert sizes["muscles"][0]["needed_f_max"] == pytest.approx(1.5 * peaks[0])
    assert sizes["infeasible_points"] == 0
    assert sizes["least_peak"]["force"] <= max(peaks) + 1e-6
    assert all(row["torque_up"] > 0 for row in sizes["coordinates"])


@pytest.mark.slow
def test_weak_muscles_are_reported(experiment: Experiment) -> None:
    weak = Experiment.load(PLANAR_2R, SLOW | {"muscles.cable_1.f_max": 15.0})
    sizes = size(weak)
    assert 0 < sizes["infeasible_points"] < sizes["points"]
    assert sizes["muscles"][0]["needed_f_max"] == pytest.approx(1.2 * 41.3, abs=0.2)
    assert "muscles are too weak; " in describe_sizes(sizes)
    strong = size(Experiment.load(PLANAR_2R, SLOW | {"muscles.cable_1.f_max": 49.7}))
    assert strong["infeasible_points"] == 0


@pytest.mark.slow
def test_moving_the_bottleneck_attachment_reduces_the_peak_force(experiment: Experiment) -> None:
    robot, motion = experiment.robot, reference_motion(experiment)
    terms = motion_terms(DartDynamics(robot), motion)
    point = size_muscles(terms).critical
    assert point is not None
    found = bottlenecks(robot, terms, point)
    assert [entry["gain"] for entry in found] == sorted((e["gain"] for e in found), reverse=True)
    worst = found[0]
    names = [muscle.name for muscle in robot.muscles]
    k, i = names.index(worst["muscle"]), worst["via_point"] - 1
    muscle = robot.muscles[k]
    assert muscle.via_points[i].link == worst["link"]
    points = list(muscle.via_points)
    place = np.array(points[i].position) + 2e-3 * np.array(worst["direction"])
    points[i] = replace(points[i], position=tuple(place.tolist()))
    moved = list(robot.muscles)
    moved[k] = replace(muscle, via_points=tuple(points))

    def least_peak(dynamics: DartDynamics) -> float:
        L = dynamics.muscle_jacobian(motion.q[point])
        answer = minimum_infinity_norm(L, terms.tau[point], dynamics.f_min, np.inf)
        return float(answer.forces.max())

    gain = least_peak(DartDynamics(robot)) - least_peak(DartDynamics(robot.with_muscles(moved)))
    assert gain == pytest.approx(2.0 * worst["gain"], rel=0.02)


@pytest.mark.slow
def test_attachments_of_muscles_at_their_minimum_force_are_not_suggested(
    experiment: Experiment,
) -> None:
    """Cables 1 and 4 only carry their pretension at the critical point."""
    robot, terms = (
        experiment.robot,
        motion_terms(DartDynamics(experiment.robot), reference_motion(experiment)),
    )
    point = size_muscles(terms).critical
    assert point is not None
    forces = minimum_infinity_norm(terms.L[point], terms.tau[point], terms.f_min, np.inf).forces
    loaded = {m.name for m, f in zip(robot.muscles, forces, strict=True) if f > m.f_min + 1.0}
    assert {entry["muscle"] for entry in bottlenecks(robot, terms, point)} == loaded
    assert loaded == {"cable_2", "cable_3"}


def test_impossible_points_are_reported(experiment: Experiment) -> None:
    """Without two of the cables, no cable pulls the arm back."""
    robot = planar_2r()
    weaker = robot.with_muscles(robot.muscles[:2])
    sizes = size_robot(weaker, reference_motion(experiment, 9))
    assert sizes["impossible_points"] > 0
    assert "no f_max is sufficient" in describe_sizes(sizes)
    with pytest.raises(InputError, match="no muscles to size, and no motors"):
        size_robot(replace(robot, cable_set=""), reference_motion(experiment, 9))


@pytest.mark.slow
def test_size_prints_a_table_or_json(cardsflow: CommandLine) -> None:
    command = ["size", PLANAR_2R, "--set", "controller.period=0.2", "--margin", "0.5"]
    code, text, _ = cardsflow(*command)
    assert code == 0
    assert "margin of 50 %" in text
    assert "cable_4" in text
    assert "via point" in text
    sizes = cardsflow.json(*command)
    assert [row["name"] for row in sizes["muscles"]] == [f"cable_{k}" for k in range(1, 5)]
    assert sizes["units"]["power"] == "W"


def test_invalid_margin_is_rejected(cardsflow: CommandLine) -> None:
    command = ["size", PLANAR_2R, "--set", "controller.period=0.5"]
    for margin in ("-1", "nan", "1e308"):
        line = cardsflow.error_line(*command, "--margin", margin)
        assert "margin must be between 0 and 1e+06" in line


@pytest.mark.slow
def test_reference_in_operational_space_is_sized() -> None:
    """The joints move the hand of the left arm along the flower; 0.5 kN are sufficient."""
    experiment = Experiment.load(LEFT_ARM)
    motion = reference_motion(experiment, 100)
    dynamics, reference = DartDynamics(experiment.robot), make_reference(experiment)
    for t, q in zip(motion.times.tolist(), motion.q, strict=True):
        np.testing.assert_allclose(dynamics.task_position(q), reference.evaluate(t).q, atol=1e-7)
    sizes = size_robot(experiment.robot, motion)
    assert sizes["infeasible_points"] == 0
    assert max(row["peak"] for row in sizes["muscles"]) == pytest.approx(495, abs=20)


@pytest.mark.slow
def test_unreachable_reference_is_reported_with_its_time() -> None:
    experiment = Experiment.load(LEFT_ARM)
    assert isinstance(experiment.reference.curve, FlowerSettings)
    far = experiment.reference.curve.copy_with(radius=3.0)
    reference = replace(experiment.reference, curve=far, approach=None)
    with pytest.raises(
        InputError, match=r"reference: at 0 s no configuration reaches hand\.x 3\.45"
    ):
        reference_motion(replace(experiment, reference=reference), 5)
    with pytest.raises(InputError, match="at least 5 points"):
        reference_motion(experiment, 3)


@pytest.mark.slow
def test_sizing_uses_the_simulated_robot_and_external_forces() -> None:
    """With 50 N at the hand for some time and a heavier arm, the torques match inverse dynamics."""
    slow = {"controller.period": 1.0}
    settings = {
        "disturbance": {"force": {"hand": [0, 0, -50]}, "begin": 10.0, "end": 20.0},
        "plant.mass_scale": 1.1,
    }
    experiment = Experiment.load(LEFT_ARM, slow | settings)
    motion = reference_motion(experiment)
    dynamics = DartDynamics(experiment.plant_robot)
    w_e = np.array([-dynamics.task_jacobian(q).T @ [0.0, 0.0, -50.0] for q in motion.q])
    w_e[(motion.times < 10.0) | (motion.times >= 20.0)] = 0.0
    terms = motion_terms(dynamics, replace(motion, w_e=w_e))
    peaks = size_muscles(terms).forces.peaks()
    np.testing.assert_allclose([row["peak"] for row in size(experiment)["muscles"]], peaks)
    assert peaks.max() > 1.2 * max(
        row["peak"] for row in size(Experiment.load(LEFT_ARM))["muscles"]
    )


def test_long_controller_period_has_the_minimum_number_of_points() -> None:
    experiment = Experiment.load(PLANAR_2R, {"controller.period": 4.0})
    assert len(reference_motion(experiment).times) == 5


@pytest.mark.slow
def test_muscle_that_only_brakes_has_zero_peak_power() -> None:
    """During a motion in one direction, lengthening cables have no positive power."""
    points = [{"time": t, "q": [0.3 * t, 0.0], "qd": [0.3, 0.0]} for t in (0.0, 1.0)]
    settings = SLOW | {"reference": {"spline": "cubic", "points": points}}
    rows = size(Experiment.load(PLANAR_2R, settings))["muscles"]
    assert all(row["peak_power"] >= 0 and row["peak_braking_power"] >= 0 for row in rows)
    assert any(row["peak_power"] == 0 and row["peak_braking_power"] > 0 for row in rows)


@pytest.mark.parametrize(("joints", "muscles"), [(3, 1), (5, 1), (4, 2), (6, 3), (2, 1), (1, 1)])
def test_robot_with_too_few_muscles_is_sized(joints: int, muscles: int) -> None:
    """Torques that the muscles cannot produce are impossible points without margins."""
    robot = random_robot(joints, joints=joints, muscles=muscles, sliding=False)
    nothing = np.zeros((3, joints))
    sizes = size_robot(robot, Motion(np.array([0.0, 1.0, 2.0]), nothing, nothing, nothing))
    assert sizes["impossible_points"] == (3 if muscles < joints else 0)
    assert describe_sizes(sizes)
