"""A run with the forces and gains of an optimal motion: accuracy, FMUs, and wrong input."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu import Experiment
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.simulation.optimal.feedback import motion_feedback
from cardsflow_fmu.simulation.optimal.files import write_motion_files
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise
from cardsflow_fmu.simulation.run import simulate
from sim_dart import CoreDynamics

TOML = """
[robot]
path = "robot/planar_2r_bodies.xml"

[start]
q = [-0.5, 0.5]

[motion]
duration = 0.6
intervals = 20
goals = [{ q = [0.6, -0.4] }]

[reference]
type = "optimised"

[controller]
type = "trajectory_feedback"

[run]
coupling = "direct"
"""

JOINTS = ("shoulder", "elbow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    own = tmp_path_factory.mktemp("feedback")
    shutil.copytree(PLANAR_2R / "robot", own / "robot")
    (own / "experiment.toml").write_text(TOML)
    write_motion_files(optimise(load_for_motion(own)), own / "motion.csv")
    return own


def hand_error(experiment: Experiment, result: Recording) -> float:
    """Return the largest distance of the end-effector point from the motion, in [m]."""
    dynamics = CoreDynamics(experiment.robot)
    names = [c.name for c in experiment.robot.coordinates]
    poses = zip(*(result.columns([f"{p}.{name}" for name in names]) for p in ("q", "q_d")))  # noqa: B905
    errors = [dynamics.task_position(q) - dynamics.task_position(q_d) for q, q_d in poses]
    return float(np.linalg.norm(errors, axis=1).max())


@pytest.mark.parametrize(("masses", "limit"), [(1.0, 1e-3), (1.1, 2.5e-3)])
def test_robot_follows_the_motion_with_its_gains(folder: Path, masses: float, limit: float) -> None:
    """Also after the end, where the feedback of the resting robot holds it."""
    own = {"plant.mass_scale": masses, "run.duration": 0.9}
    experiment = Experiment.load(folder, own)
    result = simulate(experiment)
    assert hand_error(experiment, result) < limit
    forces = np.array([result[f"f.cable_{k}"] for k in (1, 2, 3, 4)])
    assert forces.min() >= 10.0
    assert forces.max() <= 100.0


def test_limits_of_forces_do_not_change_the_torque(folder: Path) -> None:
    """The forces are the nearest ones to u: with multipliers for the torque and for the limits."""
    result = simulate(Experiment.load(folder, {"plant.mass_scale": 1.2, "run.duration": 0.3}))
    motion, experiment = Experiment.load(folder).feedback, Experiment.load(folder)
    assert motion is not None
    dynamics, limited = CoreDynamics(experiment.robot), 0
    columns = [f"{p}.joint_{k}" for p in ("q", "qd", "q_d", "qd_d") for k in (1, 2)]
    x, desired = np.split(np.array(result.columns(columns)), 2, axis=1)
    for k in range(0, 300, 5):
        row = np.searchsorted(motion.times, k * 1e-3 + 1e-9, "right") - 1
        u = motion.controls[row] + motion.gains[row] @ (desired[k] - x[k])
        f = np.array([result[f"f.cable_{i}"][k] for i in (1, 2, 3, 4)])
        L = dynamics.actuator_jacobian(x[k, :2])
        np.testing.assert_allclose(L.T @ f, L.T @ u, atol=1e-8 * abs(u).max())
        low, high = f < 10.0 + 1e-9, f > 100.0 - 1e-9
        free, change = ~(low | high), f - u
        rest = change - L @ np.linalg.lstsq(L[free], change[free], rcond=None)[0]
        assert abs(rest[free]).max(initial=0.0) < 1e-8 * abs(u).max()
        limited += (u < 10.0 - 1e-6).any()
        if free.sum() >= 2:
            assert (rest[low] > -1e-9).all()
            assert (rest[high] < 1e-9).all()
    assert limited > 20


def test_robot_holds_its_last_pose_within_the_bounds_of_the_motion(folder: Path) -> None:
    own = {"motion.intervals": 20, "motion.duration": 0.6, "motion.bounds.f_min": 15.0}
    motion = optimise(load_for_motion(folder, own))
    f, dynamics = motion.feedback.forces[-1], motion.problem.dynamics
    q = np.array([0.6, -0.4])
    np.testing.assert_allclose(-dynamics.actuator_jacobian(q).T @ f, dynamics.gravity(q), atol=1e-9)
    assert f.min() == pytest.approx(15.0)
    weak = load_for_motion(folder, {**own, "motion.bounds.f_max": 15.1})
    _, notes = motion_feedback(weak, motion.problem, motion.solution.iterate)
    assert ["hold it there" in note for note in (*motion.notes, *notes)] == [False, True]


def test_computed_torque_with_the_forces_of_the_motion_applies_them(folder: Path) -> None:
    """With 100 intervals in 1 s, the forces differ by the tracking error only."""
    settings = {"type": "joint_space", "kp": 2000.0, "kd": 90.0}
    runs = []
    for own in (settings, settings | {"feedforward": True}):
        result = simulate(Experiment.load(folder, {"controller": own}))
        runs.append(np.array([result[f"f.cable_{k}"][:-1] for k in (1, 2, 3, 4)]))
    motion = Experiment.load(folder).feedback
    assert motion is not None
    rows = np.searchsorted(motion.times, np.arange(runs[0].shape[1]) * 1e-3 + 1e-9, "right") - 1
    without, fed = (np.abs(run - motion.forces[rows].T).mean() for run in runs)
    assert fed < 0.9 * without


def edited(folder: Path, to: Path, change: str) -> str:
    """Copy the experiment with another file of gains; return its settings."""
    names, *rows = (folder / "motion.gains.csv").read_text().splitlines()
    if change == "without gains":
        names = names.replace("K.", "k.")
    elif change == "other robot":
        names = names.replace("cable_1", "muscle")
    elif change == "unknown gain":
        names = names.replace("K.f.cable_1.q.joint_1", "K.f.cable_1.q.joint_9")
    elif change == "not a number":
        time, _, *others = rows[3].split(",")
        rows[3] = ",".join([time, "nan", *others])
    elif change == "other motion":
        rows = rows[:-20]
    (to / "gains.csv").write_text("\n".join([names, *rows, ""]))
    return f"controller.gains={to / 'gains.csv'}"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("without gains", "has no gains K"),
        ("other robot", "no gain 'f.muscle.q.joint_1'"),
        ("unknown gain", "no gain 'f.cable_1.q.joint_9'"),
        ("not a number", "must be finite"),
        ("other motion", "its gains belong to another motion than [reference]"),
    ],
)
def test_wrong_file_of_gains_is_one_line(
    cardsflow: CommandLine, folder: Path, tmp_path: Path, change: str, message: str
) -> None:
    line = cardsflow.error_line("run", folder, "--set", edited(folder, tmp_path, change))
    assert "controller.gains" in line
    assert message in line


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("controller.gains=none.csv", "does not exist; compute it: `cardsflow optimise"),
        ("controller.period=0.02", "its gains are for intervals of 0.002 s"),
        ("controller.ki=1.0", "ki"),
        ("reference={points=[{time=0,q=0},{time=1,q=0}]}", "controller.gains: missing"),
        ('reference={type="rest"}', 'requires reference.type = "optimised"'),
    ],
)
def test_wrong_setting_is_one_line(
    cardsflow: CommandLine, folder: Path, setting: str, message: str
) -> None:
    assert message in cardsflow.error_line("run", folder, "--set", setting)


@pytest.mark.native
def test_native_fmus_compute_the_same_bits(folder: Path, tmp_path: Path) -> None:
    direct = simulate(Experiment.load(folder))
    files = {"run.coupling": "fmu", "run.compute": "c"}
    native = simulate(Experiment.load(folder, files))
    for name in ("q.joint_1", "qd.joint_2", "f.cable_1", "f.cable_3"):
        assert np.array_equal(direct[name], native[name])


def test_note_states_how_far_the_arm_moves_until_its_muscles_hold_it(tmp_path: Path) -> None:
    """As in the run; with a goal that holds, the muscles do so at the end of the motion."""
    arm, q = EXAMPLES / "hill_arm", [0.9, 0.6]
    own = {"motion.goals": [{"q": q}], "motion.duration": 0.25, "motion.intervals": 10}
    motion = optimise(load_for_motion(arm, own))
    (note,) = [each for each in motion.notes if "do not hold it" in each]
    file, *_ = write_motion_files(motion, tmp_path / "motion.csv")
    run = {"reference": {"type": "optimised", "file": str(file)}, "run.duration": 0.35}
    run |= {"controller": {"type": "trajectory_feedback"}, "run.coupling": "direct"}
    result = simulate(Experiment.load(arm, run))
    rows = result["time"] >= 0.25
    moved = [abs(result[f"q.{joint}"][rows] - q[k]).max() for k, joint in enumerate(JOINTS)]
    k = int(np.argmax(moved))
    stated = float(note.split(f"{JOINTS[k]} moves by ")[1].split()[0])
    assert stated == pytest.approx(moved[k], rel=0.2)
    held = {**own, "motion.goals": [{"q": q, "hold": 0.1}], "motion.duration": 0.35}
    held["motion.intervals"] = 14
    assert not any("do not hold it" in each for each in optimise(load_for_motion(arm, held)).notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("masses", "limit", "is_free"), [(1.0, 1e-3, False), (1.1, 5e-3, False), (1.0, 2e-3, True)]
)
def test_excitations_of_muscles_follow_the_motion(
    tmp_path: Path, masses: float, limit: float, is_free: bool
) -> None:
    arm = EXAMPLES / "hill_arm"
    own = {"motion.goals": [{"y": [0.5, -0.12]}], "motion.duration": 0.8, "motion.muscles": "laws"}
    own["motion.start.free_states"] = is_free  # without its activations, the run is off by 61 mm
    file, *_ = write_motion_files(optimise(load_for_motion(arm, own)), tmp_path / "motion.csv")
    settings = {
        "reference": {"type": "optimised", "file": str(file)},
        "controller": {"type": "trajectory_feedback"},
        "run.coupling": "direct",
    }
    experiment = Experiment.load(arm, {**settings, "plant.mass_scale": masses})
    assert hand_error(experiment, simulate(experiment)) < limit
