"""Free parameters of motions: closed forms, wrong input, and the files of the found robot."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.one_link import one_link
from support.robots.robots import PLANAR_2R

from addin_sdfusion.robot import WORLD, Inertia, Muscle, ViaPoint, Wrap, WrapSurface
from addin_sdfusion.robot.formats.convert import convert
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.optimal.optimise import OptimisedMotion, load_for_motion, optimise

N, ANGLE, INERTIA = 20, 0.5, 0.3
DISCRETE = N**2 / (N**2 - 1)  # least effort with constant forces in N intervals, over continuous

SLIDER = """<robot name="slider"><link name="base"/>
<link name="block"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="rail" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1000" velocity="50"/></joint></robot>"""

CONTROLLER = "[controller]\nkp = 1.0\nkd = 1.0\n"
CABLE = "robot.muscles.cable_1.points[1].position"


def _slider_motion(folder: Path, **parameter: Any) -> OptimisedMotion:
    """Return the motion of a block of 2 kg with a motor, from -0.5 m to 0.5 m in 1 s."""
    (folder / "slider.urdf").write_text(SLIDER)
    (folder / "experiment.toml").write_text(f'[robot]\npath = "slider.urdf"\n{CONTROLLER}')
    goals = [{"q": {"rail": ANGLE}}]
    motion = {"duration": 1.0, "intervals": N, "goals": goals, "parameters": [parameter]}
    settings = {"motion": motion, "robot.joints.rail.motor": True, "start.q": [-ANGLE]}
    return optimise(load_for_motion(folder / "experiment.toml", settings))


def test_stiffness_of_a_resonance_needs_no_force(tmp_path: Path) -> None:
    """Half a period of the free oscillation is the duration."""
    path = "robot.coordinates.rail.stiffness"
    motion = _slider_motion(tmp_path, path=path, **{"from": 0.0, "to": 60.0})
    assert motion.solution.cost < 1e-4
    assert motion.parameters[path] == pytest.approx(2.0 * math.pi**2, rel=1e-4)


def test_mass_balances_effort_and_weight(tmp_path: Path) -> None:
    path, weight = "robot.links.block.inertia.mass", 30.0
    own = {"path": path, "from": 0.1, "to": 5.0, "weight": weight}
    motion = _slider_motion(tmp_path, **own)
    effort = 12.0 * (2.0 * ANGLE) ** 2 * DISCRETE  # per mass squared, for a duration of 1 s
    mass = weight * 2.0 / (weight + effort)
    assert motion.parameters[path] == pytest.approx(mass, rel=1e-6)
    cost = effort * mass**2 + weight * (mass - 2.0) ** 2
    assert motion.solution.cost == pytest.approx(cost, rel=1e-6)


def test_lever_arm_balances_effort_and_weight(tmp_path: Path) -> None:
    """Two cables wind onto a drum, whose radius is their lever arm."""
    first, best, angle = 0.05, 0.08, 0.1  # at larger angles a cable leaves the drum
    drum = WrapSurface("drum", "a", "cylinder", first)
    muscles = [
        Muscle(
            f"cable_{side}",
            (ViaPoint(WORLD, (2.0, 0.0, 0.0)), ViaPoint("a", (-0.2, 0.0, 0.0))),
            f_max=1e4,
            wraps=(Wrap("drum", 0, side),),
        )
        for side in (-1, 1)
    ]
    robot = one_link(Inertia(1.0, ixx=1.0, iyy=1.0, izz=INERTIA), muscles, [drum])
    convert(robot, "sdf", tmp_path / "robot")
    toml = f'[robot]\npath = "robot/model.sdf"\ngravity = [0.0, 0.0, 0.0]\n{CONTROLLER}'
    (tmp_path / "experiment.toml").write_text(toml)
    effort = 12.0 * (INERTIA * 2.0 * angle) ** 2 * DISCRETE
    path, weight = "robot.wrap_surfaces.drum.radius", effort / (best**3 * (best - first))
    parameter = {"path": path, "from": 0.03, "to": 0.15, "weight": weight}
    goals = [{"q": {"q": angle}}]
    motion = {"duration": 1.0, "intervals": N, "goals": goals, "parameters": [parameter]}
    settings = {"motion": motion, "start.q": [-angle]}
    found = optimise(load_for_motion(tmp_path / "experiment.toml", settings))
    assert found.parameters[path] == pytest.approx(best, rel=1e-3)  # the cost is flat here
    cost = effort / best**2 + weight * (best - first) ** 2
    assert found.solution.cost == pytest.approx(cost, rel=1e-5)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    shutil.copytree(PLANAR_2R, tmp_path / "arm")
    return tmp_path / "arm" / "experiment.toml"


def _motion(*parameters: dict[str, Any]) -> str:
    """Return settings as a word for the command line."""
    text = ", ".join(
        "{" + ", ".join(f"{key} = {json.dumps(value)}" for key, value in own.items()) + "}"
        for own in parameters
    )
    goals = "goals = [{ q = { joint_1 = 0.6, joint_2 = -0.4 } }]"
    return f"motion={{duration = 1.0, intervals = {N}, {goals}, parameters = [{text}]}}"


def test_robot_with_the_found_parameters_is_written(cardsflow: CommandLine, file: Path) -> None:
    before = {path: path.read_bytes() for path in (file.parent / "robot").iterdir()}
    box = {"path": CABLE, "from": [0.02, 0.0, 0.5], "to": [0.25, 0.0, 0.95]}
    gains = "controller={type='trajectory_feedback'}"
    code, out, err = cardsflow("optimise", file, "--set", _motion(box), "--set", gains)
    assert code == 0, err
    assert "hold" not in err  # the found robot can rest at the end
    assert f"{CABLE}.x: 0.1 -> 0.02 (at the smallest value)" in out
    of_robot = file.parent / "motion_robot" / "experiment.json"
    written = Experiment.load(of_robot)
    assert cardsflow("check", of_robot)[0] == 0
    assert written.robot.muscles[0].via_points[1].position == pytest.approx((0.02, 0.0, 0.5))
    assert written.robot.muscles[1] == Experiment.load(file).robot.muscles[1]
    assert {path: path.read_bytes() for path in before} == before


def test_foreign_folder_is_not_replaced(cardsflow: CommandLine, file: Path) -> None:
    (file.parent / "motion_robot").mkdir()
    box = {"path": CABLE, "from": [0.02, 0.0, 0.5], "to": [0.25, 0.0, 0.95]}
    line = cardsflow.error_line("optimise", file, "--set", _motion(box))
    assert "motion_robot" in line
    assert "was not written by cardsflow" in line


MASS = "robot.links.link_2.inertia.mass"


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ([{"path": "run.step", "from": 0.1, "to": 0.2}], "must begin with robot.links"),
        ([{"path": "robot.muscles.cabel_1.f_max", "from": 1, "to": 2}], "did you mean 'cable_1'"),
        ([{"path": MASS + "s", "from": 0.1, "to": 0.2}], "no field 'masss'; did you mean"),
        ([{"path": CABLE, "from": 0.1, "to": 0.2}], "must be a list of 3 numbers"),
        ([{"path": CABLE, "from": [0.1, 0.0], "to": [0.2, 0.0]}], "must be a list of 3 numbers"),
        ([{"path": CABLE, "from": [0.1, 0.0], "to": [0.2, 0.0, 0.1]}], "must have 2 numbers"),
        ([{"path": MASS, "from": 0.2, "to": 0.1}], "must be at least from"),
        ([{"path": MASS, "from": 0.1, "to": 0.1}], "must be above from"),
        ([{"path": MASS, "from": 0.2, "to": 0.3}], "must contain the value of the robot, 0.1"),
        ([{"path": MASS, "from": -0.1, "to": 0.3}], "mass"),
        ([{"path": MASS, "from": "a", "to": 0.3}], "must be a number"),
        ([{"path": MASS, "from": 0.05, "to": 0.3}] * 2, "duplicate path"),
        ([{"path": "robot.muscles.cable_1.f_max", "from": 50, "to": 200}], "has no effect"),
    ],
)
def test_wrong_input_is_one_line_with_the_key(
    cardsflow: CommandLine, file: Path, parameters: list[dict[str, Any]], words: str
) -> None:
    line = cardsflow.error_line("optimise", file, "--set", _motion(*parameters))
    assert "motion.parameters[" in line
    assert words in line


def test_parameters_of_kinematics_are_rejected(cardsflow: CommandLine, file: Path) -> None:
    pose = np.array(Experiment.load(file).robot.joints[1].T_parent_joint.position)
    path = "robot.joints.joint_2.T_parent_joint.position"
    own = {"path": path, "from": (pose - 0.1).tolist(), "to": (pose + 0.1).tolist()}
    line = cardsflow.error_line("optimise", file, "--set", _motion(own))
    assert "changes the kinematics, which is not supported" in line
