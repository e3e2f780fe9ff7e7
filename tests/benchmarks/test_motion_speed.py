"""Optimal motions, compared with OpenSim Moco: `test_motion_speed.py -s`.

CARDSFlow has 50 intervals, Moco 50 or 25; Moco has a tolerance of 1e-5. Processor times:
CARDSFlow's includes reading the files and sampling the motion, Moco's only its solver.
"""

from __future__ import annotations

import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from support.interleaved import record
from support.third_party_models import REACH, SQUAT

from addin_sdfusion.robot.model.muscle import CoordinateTerm
from cardsflow_fmu.simulation.optimal.optimise import OptimisedMotion, load_for_motion, optimise

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # raised by its SWIG wrapper
    opensim: Any = pytest.importorskip("opensim", reason="needs the extra opensim")

opensim.Logger.setLevelString("Off")
MIN_RATIO = 10.0
SLIDER = """
[robot]
path = "P1.osim"
[start]
q = 0.0
[motion]
duration = [0.05, 5.0]
goals = [{ q = 1.0 }]
cost = { time = 1.0 }
[controller]
kp = 400.0
kd = 40.0
"""


def solve(study: Any, intervals: int) -> tuple[float, float]:
    """Return the cost of Moco's solution and its processor time."""
    solver = study.initCasADiSolver()
    solver.set_num_mesh_intervals(intervals)
    solver.set_optim_convergence_tolerance(1e-5)
    solver.set_optim_constraint_tolerance(1e-6)
    solver.set_verbosity(0)
    begin = time.process_time()
    solution = study.solve()
    spent = time.process_time() - begin
    assert solution.success()
    return float(solution.getObjective()), spent


def moco_slider(file: Path) -> tuple[float, float]:
    study = opensim.MocoStudy()
    problem = study.updProblem()
    problem.setModelProcessor(opensim.ModelProcessor(str(file)))
    problem.setTimeBounds(0.0, [0.0, 5.0])
    problem.setStateInfo("/jointset/slider/position/value", [-5.0, 5.0], 0.0, 1.0)
    problem.setStateInfo("/jointset/slider/position/speed", [-50.0, 50.0], 0.0, 0.0)
    problem.addGoal(opensim.MocoFinalTimeGoal("time"))
    return solve(study, 50)


def moco_squat(file: Path) -> tuple[float, float]:
    study = opensim.MocoStudy()
    problem = study.updProblem()
    problem.setModelProcessor(opensim.ModelProcessor(str(file)))
    problem.setTimeBounds(0.0, 1.0)
    for name, bounds, start in [
        ("hip_r/hip_flexion_r", [-2.0, 0.5], -2.0),
        ("knee_r/knee_angle_r", [-2.0, 0.0], -2.0),
        ("ankle_r/ankle_angle_r", [-0.5, 0.7], -0.5),
    ]:
        problem.setStateInfo(f"/jointset/{name}/value", bounds, start, 0.0)
        problem.setStateInfo(f"/jointset/{name}/speed", [-50.0, 50.0], 0.0, 0.0)
    problem.addGoal(opensim.MocoControlGoal("effort"))
    return solve(study, 25)


@pytest.fixture
def folder(shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)  # Moco writes a file
    for name in ("P1.osim", "P2.osim", "P3.osim"):
        (tmp_path / name).write_bytes((shared / "reference/moco" / name).read_bytes())
    return tmp_path


def own_motion(folder: Path, text: str) -> tuple[OptimisedMotion, float]:
    """Return the motion and its processor time."""
    (folder / "experiment.toml").write_text(text)
    begin = time.process_time()
    motion = optimise(load_for_motion(folder / "experiment.toml"))
    spent = time.process_time() - begin
    assert motion.solution.status == "optimal"
    assert motion.solution.violation < 1e-6
    return motion, spent


def test_least_time_is_found_ten_times_faster_than_by_moco(folder: Path) -> None:
    own, spent = own_motion(folder, SLIDER)
    theirs, their_time = moco_slider(folder / "P1.osim")
    cost, ratio = own.solution.cost, their_time / spent
    assert cost <= theirs
    record("motion", seconds=spent, moco=their_time, ratio=ratio, cost=cost, moco_cost=theirs)
    assert ratio > MIN_RATIO


def test_squat_to_stand_is_found_ten_times_faster_than_by_moco(folder: Path) -> None:
    own, spent = own_motion(folder, SQUAT)
    theirs, their_time = moco_squat(folder / "P2.osim")
    cost, ratio = own.solution.cost, their_time / spent
    assert cost == pytest.approx(theirs, rel=1e-3)
    record("squat", seconds=spent, moco=their_time, ratio=ratio, cost=cost, moco_cost=theirs)
    assert ratio > MIN_RATIO


@pytest.mark.parametrize(
    ("is_elastic", "moco", "tolerance"), [(0, 0.5187, 3e-3), (1, 0.4747, 0.01)]
)
def test_reach_with_muscles_costs_as_much_as_with_the_rates_of_opensim(
    folder: Path, is_elastic: int, moco: float, tolerance: float
) -> None:
    """The rate of BIClong in OpenSim 4.6 is not that of its length, over an ellipsoid.

    By the shoulder it is larger by about 0.3 mm/rad on this motion. With a term of this size, the
    cost is that of Moco; with elastic tendons, of Moco with only 25 intervals. The bound of the
    shoulder excludes a motion that swings back first.
    """
    direct = REACH.replace("r_shoulder_elev = -1.0", "r_shoulder_elev = 0.0")
    text = f"{direct}[muscles]\n'*' = {{ model.elastic_tendon = {is_elastic} }}\n"
    own, spent = own_motion(folder, text)
    experiment = load_for_motion(folder / "experiment.toml")
    term = (CoordinateTerm("r_shoulder_elev", -0.0003),)
    muscles = [
        replace(muscle, terms=term) if muscle.name == "BIClong" else muscle
        for muscle in experiment.robot.muscles
    ]
    with_term = optimise(replace(experiment, robot=experiment.robot.with_muscles(muscles)))
    cost, corrected = own.solution.cost, with_term.solution.cost
    record("reach", seconds=spent, cost=cost, with_rates_of_opensim=corrected)
    assert corrected == pytest.approx(moco, rel=tolerance)
