"""Optimal motions as good as those of fine collocation.

The numbers are of Hermite-Simpson collocation with 100 to 200 intervals, own equations of motion,
CasADi 3.8 and IPOPT with the tolerance 1e-9, from several guesses.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.robots.muscle_bench import slider
from support.third_party_models import REACH, without_ellipsoids

from addin_sdfusion.robot.formats.opensim.write import write_osim
from cardsflow_fmu.simulation.optimal.optimise import load_for_motion, optimise

_LINK = (
    '<link name="{}"><inertial><origin xyz="{}"/><mass value="{}"/><inertia ixx="1e-6"'
    ' iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
)
_JOINT = (
    '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><origin xyz="{}"/>'
    '<axis xyz="{}"/><limit lower="-2" upper="2" effort="20" velocity="50"/></joint>'
)
_ROD = 1.0, 1.0 / 12.0, 1.0 / 12.0
ROBOTS = {
    "arm": (
        _LINK.format("a", "0.5 0 0", *_ROD),
        _LINK.format("b", "0.5 0 0", *_ROD),
        _JOINT.format("j1", "continuous", "base", "a", "0 0 0", "0 0 1"),
        _JOINT.format("j2", "continuous", "a", "b", "1 0 0", "0 0 1"),
    ),
    "cart": (
        _LINK.format("cart", "0 0 0", 1.0, 0.01, 0.01),
        _LINK.format("pole", "0 0 -0.5", 0.3, 1e-6, 1e-6),
        _JOINT.format("rail", "prismatic", "base", "cart", "0 0 0", "1 0 0"),
        _JOINT.format("hinge", "continuous", "cart", "pole", "0 0 0", "0 1 0"),
    ),
}
MOTIONS = {
    # from rest, |tau| <= 10 and 5 N m, horizontal
    "arm": (
        "duration = [0.2, 5.0]\ngoals = [{ q = { j1 = 1.0, j2 = -0.5 } }]\ncost = { time = 1.0 }",
        {"j1": 10.0, "j2": 5.0},
        0.827508,
    ),
    # 1 kg and 0.3 kg at 0.5 m, 1 m in 2 s, |F| <= 20 N: the example of Kelly (2017)
    "cart": (
        "duration = 2.0\ngoals = [{ q = { rail = 1.0, hinge = -3.141592653589793 } }]",
        {"rail": 20.0},
        58.8084,
    ),
}


@pytest.mark.parametrize("name", MOTIONS)
def test_motion_costs_at_most_one_percent_more(name: str, tmp_path: Path) -> None:
    motion, motors, best = MOTIONS[name]
    parts = "".join(ROBOTS[name])
    (tmp_path / "robot.urdf").write_text(f'<robot name="r"><link name="base"/>{parts}</robot>')
    joints = "".join(f"[robot.joints.{j}]\nmotor = true\neffort = {f}\n" for j, f in motors.items())
    text = f'[robot]\npath = "robot.urdf"\n{joints}[start]\nq = 0.0\n[motion]\n{motion}\n'
    (tmp_path / "experiment.toml").write_text(f"{text}[controller]\nkp = 100.0\nkd = 20.0\n")
    found = optimise(load_for_motion(tmp_path / "experiment.toml"))
    assert found.solution.status == "optimal"
    assert found.solution.violation < 1e-6
    assert found.solution.cost <= 1.01 * best


@pytest.mark.parametrize(("is_elastic", "moco"), [(0, 0.0809272), (1, 0.0831612)])
def test_hanging_muscle_lifts_its_load_as_fast_as_in_moco(
    is_elastic: int, moco: float, tmp_path: Path
) -> None:
    """OpenSim Moco 4.6, 50 intervals, tolerance 1e-5: 1.9 and 4.6 s of processor time."""
    muscle = {"max_isometric_force": 60.0, "optimal_fibre_length": 0.1}
    muscle |= {"tendon_slack_length": 0.05, "tendon_strain": 0.1, "fibre_damping": 0.01}
    robot = slider(("hill_degroote2016", {**muscle, "elastic_tendon": float(is_elastic)}))
    write_osim(replace(robot, gravity=(9.81, 0.0, 0.0)), tmp_path, "robot")
    text = '[robot]\npath = "robot.osim"\n[start]\nq = 0.165\n[motion]\nmuscles = "laws"\n'
    text += "start_command = 0.01\nduration = [0.05, 1.0]\ngoals = [{ q = 0.155 }]\n"
    text += "cost = { time = 1.0 }\n[motion.bounds]\nu_min = 0.01\nu_max = 1.0\n"
    text += "q_min = 0.1\nq_max = 0.2\nqd_max = 10.0\n"
    (tmp_path / "experiment.toml").write_text(f"{text}[controller]\nkp = 100.0\nkd = 20.0\n")
    found = optimise(load_for_motion(tmp_path / "experiment.toml"))
    assert found.solution.status == "optimal"
    assert found.duration == pytest.approx(moco, rel=5e-4)


@pytest.mark.parametrize(
    ("is_elastic", "intervals", "moco"), [(0, 25, 0.8127047), (1, 50, 0.7424317)]
)
def test_reach_with_muscles_costs_as_much_as_in_moco(
    shared: Path, is_elastic: int, intervals: int, moco: float, tmp_path: Path
) -> None:
    """OpenSim Moco 4.6, 25 intervals, tolerance 1e-5: 19 and 38 s of processor time.

    The bound of the shoulder excludes a motion that swings back first, which costs less.
    """
    (tmp_path / "P3.osim").write_bytes((shared / "reference/moco/P3.osim").read_bytes())
    text = REACH.replace("r_shoulder_elev = -1.0", "r_shoulder_elev = 0.0")
    text = text.replace("[motion]", f"[motion]\nintervals = {intervals}")
    text += f"[muscles]\n'*' = {{ model.elastic_tendon = {is_elastic} }}\n"
    (tmp_path / "experiment.toml").write_text(text)
    experiment = load_for_motion(tmp_path / "experiment.toml")
    robot = without_ellipsoids(experiment.robot)
    found = optimise(replace(experiment, robot=robot))
    assert found.solution.status == "optimal"
    assert found.solution.violation < 1e-6
    assert found.solution.cost == pytest.approx(moco, rel=0.01)
