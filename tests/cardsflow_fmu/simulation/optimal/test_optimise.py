"""`cardsflow optimise`: from an experiment to a motion that a run follows, and wrong input."""

from __future__ import annotations

import json
import shlex
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.third_party_models import SQUAT

from cardsflow_fmu import Experiment
from cardsflow_fmu.experiment.reader import follows_motion
from cardsflow_fmu.models.start_commands import start
from cardsflow_fmu.simulation.optimal.files import write_motion_files
from cardsflow_fmu.simulation.optimal.optimise import (
    OptimisedMotion,
    load_for_motion,
    optimise,
)
from cardsflow_fmu.simulation.optimal.problem import MotionProblem, motion_problem
from cardsflow_fmu.utils.csv_table import read_csv
from controllers.optimal.sqp import Optimiser, Solution
from sim_dart import CoreDynamics, Plant

PENDULUM = """<robot name="pendulum"><link name="base"/>
<link name="rod"><inertial><origin xyz="0 0 -1"/><mass value="1"/>
<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="pivot" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
<limit effort="3" velocity="50"/></joint></robot>"""

SWING_UP = """
[robot]
path = "pendulum.urdf"

[robot.joints.pivot]
motor = true
effort = 3.0

[start]
q = 0.0

[motion]
duration = 6.0
intervals = 100
goals = [{ q = 3.141592653589793 }]

[controller]
kp = 100.0
kd = 20.0
"""


def test_run_follows_the_optimised_motion(cardsflow: CommandLine, file: Path) -> None:
    assert f"compute it: `cardsflow optimise {file}`" in cardsflow.error_line("run", file)
    code, out, err = cardsflow("optimise", file)
    assert code == 0, err
    assert "iteration" in err
    assert out.startswith("cost ")
    next_words = shlex.split(out.splitlines()[-1])[1:]
    assert next_words[:2] == ["cardsflow", "run"]
    names, rows = read_csv(file.parent / "motion.csv", kind="motion", most=1_000_000)
    motion = dict(zip(names, rows.T, strict=True))
    assert motion["time"][-1] == 0.6
    ends = [[motion[f"{p}.joint_{k}"][row] for p in ("q", "qd") for k in (1, 2)] for row in (0, -1)]
    np.testing.assert_allclose(ends, [[-0.5, 0.5, 0, 0], [0.6, -0.4, 0, 0]], atol=1e-6)
    forces = np.array([motion[f"f.cable_{k}"] for k in (1, 2, 3, 4)])
    assert forces.min() >= 10.0
    summary = cardsflow.json(*next_words[1:])
    assert summary["tracking"]["rms"] < 5e-3
    line = cardsflow.error_line("run", file, "--set", "start.q=[0.2, 0.5]")
    assert "motion.csv begins at another pose than [start]; compute it again" in line
    reference = Experiment.load(file, {"controller.type": "operational_space"}).reference
    assert reference.space == "operational"
    dynamics = CoreDynamics(Experiment.load(file).robot)
    last = dynamics.task_position([0.6, -0.4])
    np.testing.assert_allclose(reference.curve.points[-1].q, last, atol=1e-6)
    assert (file.parent / "motion.svg").is_file()
    again = cardsflow.json("optimise", file)  # replaces its own files
    assert again["status"] == "optimal"
    assert 0.0 < again["active_bounds"]["f.cable_1 minimum"] < 1.0


def test_motion_without_a_controller_is_followed_with_its_own_feedback(file: Path) -> None:
    text = file.read_text()
    file.write_text(text[: text.index("[reference]")])
    assert follows_motion(file, {})
    assert not follows_motion(file, {"controller.kp": 1.0})
    write_motion_files(optimise(load_for_motion(file)), file.parent / "motion.csv")
    followed = {"reference.type": "optimised", "controller.type": "trajectory_feedback"}
    own, explicit = Experiment.load(file), Experiment.load(file, followed)
    assert own.controller == explicit.controller
    assert own.reference.curve.points == explicit.reference.curve.points


def test_infeasible_motion_names_constraint_node_and_forces(
    cardsflow: CommandLine, file: Path
) -> None:
    code, out, err = cardsflow("optimise", file, "--set", "motion.duration=0.1")
    assert (code, out) == (1, "")
    line = err.splitlines()[-1]
    assert line.startswith("cardsflow: no motion found: q.joint_1 must be 0.6, but is ")
    assert "at node 20 of 20 (t = 0.1 s)" in line
    assert not (file.parent / "motion.csv").exists()


@pytest.mark.parametrize(
    ("setting", "key", "message"),
    [
        ("motion.duration=0", "motion.duration", "must be positive"),
        ("motion.duration=[2.0,1.0]", "motion.duration", "must increase"),
        ("motion.duration=[1.0]", "motion.duration", "must be a number, or a list"),
        ("motion.duration=nan", "motion.duration", "must be positive and finite"),
        ("motion.intervals=1", "motion.intervals", "at least 2"),
        ("motion.intervals=2.5", "motion.intervals", "2.5"),
        ("motion.substeps=0", "motion.substeps", "at least 1"),
        ("motion.goals=[]", "motion.goals", "at least one table"),
        ("motion.goals=[{}]", "motion.goals[0].q", "missing; set q, y"),
        ("motion.goals=[{yd={'tip.x'=1.0},rest=true}]", "motion.goals[0].rest", "excludes qd"),
        ("motion.goals=[{qd=[1.0,0.0],hold=0.06}]", "motion.goals[0].hold", "excludes qd"),
        ("motion.goals=[{q={joint_3=1.0}}]", "motion.goals[0].q.joint_3", "did you mean"),
        ("motion.goals=[{q=[1.0]}]", "motion.goals[0].q", "must have 2 values"),
        ("motion.goals=[{y={hand=1.0}}]", "motion.goals[0].y.hand", "no task coordinate"),
        ("motion.goals=[{y=[1.0,2.9]}]", "motion.goals[0].y", "no configuration reaches"),
        ("motion.goals=[{q=[9.0,0.0]}]", "motion.goals[0].q.joint_1", "within the bounds"),
        ("motion.goals=[{time=0.7,q=[0,0]}]", "motion.goals[0].time", "within the duration"),
        ("motion.goals=[{time=0.1,q=[0,0]}]", "motion.goals[0].time", "multiple of an interval"),
        ("motion.goals=[{fraction=0.33,q=[0,0]}]", "motion.goals[0].fraction", "multiple of an"),
        ("motion.goals=[{time=0.0,q=[0,0]}]", "motion.goals[0].time", "motion.start determines"),
        ("motion.goals=[{fraction=1.5,q=[0,0]}]", "motion.goals[0].fraction", "from 0 to 1"),
        (
            "motion.goals=[{fraction=0.5,time=0.3,q=[0,0]}]",
            "motion.goals[0].fraction",
            "excludes time",
        ),
        ("motion.goals=[{hold=0.01,q=[0,0]}]", "motion.goals[0].hold", "multiple of an interval"),
        (
            "motion.goals=[{time=0.3,hold=0.6,q=[0,0]}]",
            "motion.goals[0].hold",
            "must end within the duration",
        ),
        ("motion.start.free=['joint_9']", "motion.start.free", "did you mean"),
        ("motion.start.y={hand=1.0}", "motion.start.y.hand", "no task coordinate"),
        ("motion.goals=[{q=[0,0],weight=0}]", "motion.goals[0].weight", "must be above 0"),
        ("motion.periodic={joint_9=0.0}", "motion.periodic.joint_9", "did you mean"),
        ("motion.cost.accelerations=-1.0", "motion.cost.accelerations", "must not be negative"),
        ("motion.cost.tracking={file='a.csv'}", "motion.cost.tracking.q", "set q or y"),
        ("motion.cost.tracking={q=1.0}", "motion.cost.tracking.file", "missing"),
        ("motion.cost.tracking={file='a.csv',q=1.0}", "motion.cost.tracking.file", "a.csv"),
        ("motion.cost.function='cost'", "motion.cost.function", "must be <file>.py:<class>"),
        ("motion.bounds.f_rate_max=0", "motion.bounds.f_rate_max", "must be above 0"),
        ("motion.bounds.y_min={'tip.x'=5.0}", "motion.bounds.y_min.tip.x", "starts at -0.47"),
        (
            "motion.bounds={y_min={'tip.x'=5.0},y_max={'tip.x'=1.0}}",
            "motion.bounds.y_max.tip.x",
            "at least the minimum",
        ),
        ("motion.goals=[{where=1}]", "motion.goals[0].where", "no key 'where'"),
        (
            "motion.obstacles=[{centre=[0,0,0],radius=0.1,points=['hand']}]",
            "motion.obstacles[0].points",
            "no end-effector point 'hand'",
        ),
        (
            "motion.obstacles=[{centre=[0,0,0],radius=9.0}]",
            "motion.obstacles[0]",
            "contains 'tip' at the start",
        ),
        (
            "motion.obstacles=[{centre=[0,0,0],radius=0.1,links=['upper']}]",
            "motion.obstacles[0].links",
            "no link with a length 'upper'",
        ),
        (
            "motion.obstacles=[{centre=[0,0,0],radius=0.1,cables=['cable_9']}]",
            "motion.obstacles[0].cables",
            "did you mean",
        ),
        (
            "motion.obstacles=[{centre=[0,0,0],end=[0,1,0],radius=0.1,links=['*']}]",
            "motion.obstacles[0]",
            "at the start, 0 m from its axis",
        ),
        (
            "motion.obstacles=[{centre=[0,0,0],radius=0.1,clearance=-1}]",
            "motion.obstacles[0].clearance",
            "must not be negative",
        ),
        ("motion.cost={force=1.0}", "motion.cost.force", "did you mean 'forces'"),
        ("motion.cost={forces=-1.0}", "motion.cost.forces", "must not be negative"),
        ("motion.cost={commands=1.0}", "motion.cost.commands", 'requires motion.muscles = "laws"'),
        ("motion.bounds.f_min=-1.0", "motion.bounds.f_min.cable_1", "cannot push, not -1"),
        ("motion.bounds.f_max=1.0", "motion.bounds.f_max.cable_1", "at least the minimum"),
        ("motion.bounds.q_max.joint_1=-0.6", "start.q.joint_1", "bounds -3.1"),
        ("motion.bounds.qd_max.joint_9=1.0", "motion.bounds.qd_max.joint_9", "did you mean"),
    ],
)
def test_wrong_input_is_one_line_with_the_key(
    cardsflow: CommandLine, file: Path, setting: str, key: str, message: str
) -> None:
    code, out, err = cardsflow("optimise", file, "-q", "--set", setting)
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert lines[0].startswith(f"cardsflow: {file}: {key}: ")
    assert message in lines[0]
    assert len(lines) == 1


def test_squat_to_stand_costs_as_much_as_with_moco(shared: Path, tmp_path: Path) -> None:
    """Within 0.1 % of the converged cost, with the constraints satisfied to 1e-6."""
    reference = shared / "reference/moco"
    robot = tmp_path / "P2.osim"
    robot.write_bytes((reference / "P2.osim").read_bytes())
    joints = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")
    (tmp_path / "experiment.toml").write_text(SQUAT)
    motion = optimise(load_for_motion(tmp_path / "experiment.toml"))
    best = json.loads((reference / "P2.json").read_text())["best_cost"]
    assert motion.solution.status == "optimal"
    assert motion.solution.cost == pytest.approx(best, rel=1e-3)
    assert motion.solution.history[-1].violation < 1e-6
    ends = [[motion.columns[f"q.{name}"][row] for name in joints] for row in (0, -1)]
    np.testing.assert_allclose(ends, [[-2.0, -2.0, -0.5], [0.0, 0.0, 0.0]], atol=1e-6)


def test_pendulum_swings_up_with_less_torque_than_its_weight(tmp_path: Path) -> None:
    """Energy: the work of the motor is the change of the potential energy, m g d = 2 m g l.

    With few and many substeps, the motion costs the same: both are optimal. The best cost is that
    of Hermite-Simpson collocation, 200 intervals, from six guesses.
    """
    (tmp_path / "pendulum.urdf").write_text(PENDULUM)
    (tmp_path / "experiment.toml").write_text(SWING_UP)
    motion = optimise(load_for_motion(tmp_path / "experiment.toml"))
    assert motion.solution.status == "optimal"
    pairs = pairwise(own for own, _ in motion.history)
    rough = [own.cost for own, following in pairs if following.iteration == 0]
    assert rough == pytest.approx([motion.solution.cost] * len(rough), rel=1e-3)
    assert motion.solution.cost == pytest.approx(15.99550, rel=0.01)
    torque, speed = motion.columns["tau.pivot"], motion.columns["qd.pivot"]
    assert abs(torque).max() <= 3.0 + 1e-9  # the weight is 9.81 N·m
    work = np.trapezoid(torque * speed, motion.times)
    assert work == pytest.approx(2.0 * 9.81, rel=1e-2)


def test_stretched_muscles_start_as_in_a_run_or_are_reported() -> None:
    """Passive tensions bound what muscles hold; a plan of forces alone does not contain them."""
    own = {"motion.goals": [{"y": [0.35, -0.42]}], "motion.duration": 0.8, "motion.intervals": 5}
    own |= {"muscles.*.model.optimal_fibre_length": 0.06}
    motion = optimise(load_for_motion(EXAMPLES / "hill_arm", {**own, "motion.muscles": "forces"}))
    assert any("will not be followed" in line for line in motion.notes)
    experiment = load_for_motion(EXAMPLES / "hill_arm", own)
    plant, q = Plant(experiment.robot, step=1e-3), experiment.start.q
    plant.reset(q, commands=start(experiment.robot, q).commands)
    begin = motion_problem(experiment).guess.x[0, 4:]
    np.testing.assert_allclose(begin, plant.get_state()[-len(begin) :], rtol=1e-6, atol=1e-9)


def test_motion_converges_although_the_filter_rejects_steps_near_the_optimum() -> None:
    own = {"motion.goals": [{"y": [0.45, -0.2]}], "motion.duration": 0.8, "motion.intervals": 20}
    motion = optimise(load_for_motion(EXAMPLES / "hill_arm", own))
    assert motion.problem.shooting.laws.state_names
    assert motion.solution.status == "optimal"


@cache
def hill_arm_motion(is_elastic: int, **more: bool) -> tuple[Experiment, OptimisedMotion]:
    """Return the motion of a Hill-type arm to a point, by excitations."""
    own = {"motion.goals": [{"y": [0.5, -0.12]}], "motion.duration": 0.8, "motion.muscles": "laws"}
    own |= {"muscles.*.model.elastic_tendon": is_elastic, "motion.intervals": 20}
    own |= {f"motion.start.{key}": value for key, value in more.items()}
    experiment = load_for_motion(EXAMPLES / "hill_arm", own)
    return experiment, optimise(experiment)


@pytest.mark.parametrize("is_elastic", [0, 1])
def test_excitations_of_muscle_laws_reach_the_goal(is_elastic: int) -> None:
    """The written excitations, replayed with the plant, reach the end of the motion."""
    experiment, motion = hill_arm_motion(is_elastic)
    assert motion.solution.status == "optimal"
    robot, names = experiment.robot, [muscle.name for muscle in experiment.robot.muscles]
    plant = Plant(robot, step=1e-3, integrator="rk4")
    plant.reset(experiment.start.q)
    states = [motion.columns[name] for name in plant.muscle_state_names]
    state = plant.get_state()
    state[-len(states) :] = [rows[0] for rows in states]
    plant.set_state(state)
    u = np.array([motion.columns[f"u.{name}"] for name in names]).T
    for row in u[:-1]:
        plant.step(row)
    np.testing.assert_allclose(plant.task_position, [0.5, -0.12], atol=1e-4)


def test_free_states_of_muscles_reduce_the_cost() -> None:
    """A muscle that is activated at the start needs less excitation afterwards; a run starts so."""
    (_, fixed), (experiment, found) = hill_arm_motion(0), hill_arm_motion(0, free_states=True)
    assert found.solution.status == "optimal"
    assert found.solution.cost < 0.5 * fixed.solution.cost
    np.testing.assert_array_equal(found.solution.iterate.x[0, :4], fixed.solution.iterate.x[0, :4])
    robot, q = experiment.robot, experiment.start.q
    commands = start(robot, q, found.feedback).commands
    assert commands == tuple(found.columns[f"activation.{m.name}"][0] for m in robot.muscles)


def test_passive_joint_with_a_stiff_spring_is_integrated_accurately(file: Path) -> None:
    """The joint has 350 rad/s and a time constant of 1 ms; intervals are 30 ms."""
    spring = {"stiffness": 300.0, "rest": 0.0, "damping": 2.0}
    own = {"robot.coordinates.joint_2": spring, "start.q": [-0.3, 0.0], "motion.duration": 0.6}
    own |= {"motion.goals": [{"q": {"joint_1": 0.3}}], "controller.passive.joint_2": True}
    motion = optimise(load_for_motion(file, own))
    assert motion.solution.status == "optimal"
    assert not motion.warnings
    at, ends = motion.solution.iterate, motion.solution.linearisation.ends
    assert motion.problem.refine(at, np.inf, ends=ends) < 1e-2


def test_rough_error_that_falls_by_the_second_doubling_is_reduced(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a MuJoCo muscle whose activation rises in a fraction of an interval."""
    ends = {1: 0.097, 2: 0.023, 4: 6e-4, 8: 1e-6}
    monkeypatch.setattr(
        MotionProblem,
        "_ends",
        lambda self, at, steps, nodes: np.array([[ends.get(steps[k], 0.0)] for k in nodes]),
    )
    setup = motion_problem(load_for_motion(file))
    assert setup.refine(setup.guess, 1e-5, is_final=True) == 1e-6
    assert (setup.shooting.steps == 8).all()


def test_only_inaccurate_intervals_are_refined(file: Path) -> None:
    """The last half of the motion rests; its error is 0 with a single step."""
    problem = motion_problem(load_for_motion(file))
    fast = problem.guess.x.copy()
    fast[:10, 2:] = 20.0
    error = problem.refine(problem.guess._replace(x=fast), 1e-3, is_final=True)
    assert error < 1e-3
    assert (problem.shooting.steps[:10] > 1).all()
    assert (problem.shooting.steps[10:] == 1).all()


def test_a_motion_that_cannot_be_refined_is_kept(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As with forces that jump: no motion is found with more substeps."""
    solve, found = Optimiser.solve, list[Solution | None]()

    def solve_once(self: Optimiser, *arguments: Any) -> Solution | None:
        found.append(None if found else solve(self, *arguments))
        return found[-1]

    monkeypatch.setattr(Optimiser, "solve", solve_once)
    motion = optimise(load_for_motion(file, {"motion.intervals": 10}))
    assert found == [motion.solution, None]
    note = f"the integration error of an interval is up to {_largest_error(motion):.2g}"
    assert any(line.startswith(note) for line in (*motion.notes, *motion.warnings))


def _largest_error(motion: OptimisedMotion) -> float:
    """Return the largest change of the ends of intervals by twice the substeps."""
    problem, at = motion.problem.problem, motion.solution.iterate
    shooting, ends = motion.problem.shooting, []
    for factor in (1, 2):
        with shooting.using(factor * np.broadcast_to(shooting.steps, len(at.u))):
            intervals = problem.run(at, derivatives=False)
            assert intervals is not None
            ends.append(intervals.ends)
    return float(abs(ends[0] - ends[1]).max())


def test_muscles_with_ranges_of_states_by_parameters_have_motions() -> None:
    own = {"duration": 0.8, "intervals": 10, "muscles": "laws", "goals": [{"q": 0.9}]}
    motion = optimise(load_for_motion(EXAMPLES / "pneumatic_elbow", {"motion": own}))
    assert motion.solution.status == "optimal"


def test_experiment_without_motion_is_rejected_with_an_example(cardsflow: CommandLine) -> None:
    assert "[motion]" not in (PLANAR_2R / "experiment.toml").read_text()
    line = cardsflow.error_line("optimise", PLANAR_2R, "-q")
    assert "motion: missing; for example: duration = 1.0" in line


def test_robot_rests_at_the_start_with_the_reference_rest(file: Path) -> None:
    experiment = Experiment.load(file, {"reference": {"type": "rest"}, "start.q": [0.1, 0.2]})
    assert {point.q for point in experiment.reference.curve.points} == {(0.1, 0.2)}
