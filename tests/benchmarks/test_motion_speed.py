"""An optimal motion, compared with OpenSim Moco: `test_motion_speed.py -s`.

Both have 50 intervals; Moco has a tolerance of 1e-5. Processor times: CARDSFlow's includes reading
the files and sampling the motion, Moco's only its solver.
"""

from __future__ import annotations

import time
import warnings
from pathlib import Path
from typing import Any

import pytest
from support.interleaved import record

from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise

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


def moco(file: Path) -> tuple[float, float]:
    """Return the cost of Moco's solution and its processor time."""
    study = opensim.MocoStudy()
    problem = study.updProblem()
    problem.setModelProcessor(opensim.ModelProcessor(str(file)))
    problem.setTimeBounds(0.0, [0.0, 5.0])
    problem.setStateInfo("/jointset/slider/position/value", [-5.0, 5.0], 0.0, 1.0)
    problem.setStateInfo("/jointset/slider/position/speed", [-50.0, 50.0], 0.0, 0.0)
    problem.addGoal(opensim.MocoFinalTimeGoal("time"))
    solver = study.initCasADiSolver()
    solver.set_num_mesh_intervals(50)
    solver.set_optim_convergence_tolerance(1e-5)
    solver.set_optim_constraint_tolerance(1e-6)
    solver.set_verbosity(0)
    begin = time.process_time()
    solution = study.solve()
    spent = time.process_time() - begin
    assert solution.success()
    return float(solution.getObjective()), spent


def test_least_time_is_found_ten_times_faster_than_by_moco(
    shared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # Moco writes a file
    robot = tmp_path / "P1.osim"
    robot.write_bytes((shared / "reference/moco/P1.osim").read_bytes())
    (tmp_path / "experiment.toml").write_text(SLIDER)
    theirs, their_time = moco(robot)
    begin = time.process_time()
    own = optimise(load_for_motion(tmp_path / "experiment.toml"))
    spent = time.process_time() - begin
    cost, ratio = own.solution.cost, their_time / spent
    assert own.solution.violation < 1e-6
    assert cost <= theirs
    record("motion", seconds=spent, moco=their_time, ratio=ratio, cost=cost, moco_cost=theirs)
    assert ratio > MIN_RATIO
