"""Findings of `cardsflow check` on drives, for robots and experiments."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.loops import four_bar, with_loop
from support.robots.one_link import cable, one_link
from support.robots.robots import EXAMPLES, PLANAR_2R

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    Inertia,
    InputError,
    Joint,
    Link,
    Robot,
    revolute,
    write_caspr,
    write_sdf,
)
from addin_sdfusion.robot.model.pose import Pose
from cardsflow_fmu import check
from cardsflow_fmu.results.analysis import drive_check
from cardsflow_fmu.results.analysis.first_motion import first_motion
from sim_dart import Plant

Y = (0.0, 1.0, 0.0)
LIGHT = Inertia(1.0, (0.2, 0.0, 0.0), 0.01, 0.01, 0.01)
CODES = ("massless-motion", "coordinate-without-muscle", "pose-not-held", "motion-not-held")


def arm(height: float, **coordinate: float) -> Robot:
    strand = cable((-0.1, 0.0, height), (0.3, 0.0, 0.0), f_max=100.0)
    return one_link(LIGHT, [strand], motions=revolute(Y), **coordinate)


def find_messages(cardsflow: CommandLine, *words: object) -> dict[str, str]:
    """Return the messages of findings of `CODES`, by code."""
    _, out, _ = cardsflow("check", *words)
    lines = [line for line in out.splitlines() if line.endswith(tuple(f"[{c}]" for c in CODES))]
    return {line.rpartition("[")[2][:-1]: line for line in lines}


def test_pose_that_muscles_can_hold_has_no_finding(tmp_path: Path, cardsflow: CommandLine) -> None:
    write_sdf(arm(0.5), tmp_path)
    assert find_messages(cardsflow, tmp_path) == {}


@pytest.mark.parametrize("muscles", [True, False])
@pytest.mark.parametrize(
    ("changes", "gap"),
    [
        ({"T_child_joint": Pose((5.0, 0.0, 0.0))}, "3.8 m"),  # 5 m less coupler, crank and ground
        (
            {"type": "fixed", "axes": (), "T_child_joint": Pose((0.4, 0.0, 0.0), (0.5, 0.0, 0.0))},
            "0.5 rad",  # about an axis without a joint
        ),
    ],
    ids=["too far", "over-constrained"],
)
def test_loop_that_cannot_be_closed_is_reported(
    changes: dict[str, object], gap: str, muscles: bool, tmp_path: Path, cardsflow: CommandLine
) -> None:
    """A robot in Python, a robot file and a plant have the same message."""
    whole = with_loop(four_bar(), **changes)
    robot = whole if muscles else replace(whole, cable_sets=(), cable_set="")
    write_sdf(robot, tmp_path / "robot")
    (said,) = [str(finding) for finding in check(robot) if finding.code == "not-simulated"]
    assert said in cardsflow("check", tmp_path / "robot")[1].splitlines()
    with pytest.raises(InputError, match="loop cannot be closed") as refused:
        Plant(robot)
    assert str(refused.value) in said
    assert f"joint 'closing': its loop cannot be closed; the remaining gap is {gap}" in said


def test_loop_of_zero_length_is_an_error() -> None:
    found = check(with_loop(four_bar(), parent="rocker_bar"))
    assert [finding.code for finding in found if finding.is_error] == ["loop-of-no-length"]


def test_pose_that_muscles_cannot_hold_is_a_warning(tmp_path: Path, cardsflow: CommandLine) -> None:
    write_sdf(arm(-0.5), tmp_path)
    assert (
        "no muscle produces negative torque at q"
        in find_messages(cardsflow, tmp_path)["pose-not-held"]
    )  # negative q is upwards


def test_coordinate_without_muscle_is_a_warning(tmp_path: Path, cardsflow: CommandLine) -> None:
    wrist = Joint("wrist", "a", "hand", revolute(Y), (Coordinate("wrist"),))
    robot = arm(0.5)
    robot = replace(robot, links=(*robot.links, Link("hand", LIGHT)), joints=(*robot.joints, wrist))
    write_sdf(robot, tmp_path)
    messages = find_messages(cardsflow, tmp_path)
    assert list(messages) == ["coordinate-without-muscle"]
    assert "coordinate 'wrist'" in messages["coordinate-without-muscle"]


def massless() -> Robot:
    """Return a robot with a mass on the axis of a joint; a second joint moves it off this axis."""
    rod = Inertia(1.0, (0.0, 0.0, 0.2), 0.0, 0.0, 0.0)
    twist = Joint("twist", "world", "shaft", revolute((0.0, 0.0, 1.0)), (Coordinate("twist"),))
    swing = Joint("swing", "shaft", "rod", revolute(Y), (Coordinate("swing"),), Pose())
    strand = replace(cable((-0.1, 0.0, 0.5), (0.05, 0.0, 0.2)), f_max=50.0)
    strand = replace(
        strand, via_points=(strand.via_points[0], replace(strand.via_points[1], link="rod"))
    )
    robot = one_link(rod, [strand])
    return replace(
        robot, links=(Link("shaft", Inertia(0.0)), Link("rod", rod)), joints=(twist, swing)
    )


@pytest.mark.parametrize("engine", ["core", "dart"])
def test_massless_motion_is_rejected_by_both_engines(
    engine: str, tmp_path: Path, cardsflow: CommandLine
) -> None:
    write_sdf(massless(), tmp_path / "robot")
    code, _, _ = cardsflow("check", tmp_path / "robot")
    assert code == 1
    assert "coordinate 'twist'" in find_messages(cardsflow, tmp_path / "robot")["massless-motion"]
    (tmp_path / "experiment.toml").write_text(
        '[robot]\npath = "robot"\n[reference]\nspline = "quintic"\n'
        "points = [{ time = 0.0, q = [0.0, 0.0] }, { time = 0.1, q = [0.0, 0.0] }]\n"
        f'[controller]\nkp = 1.0\nkd = 1.0\nengine = "{engine}"\n'
        f'[plant]\nengine = "{engine}"\n[run]\nstep = 0.001\n'
    )
    message = cardsflow.error_line("run", tmp_path, "--coupling", "direct", "-o", tmp_path / "out")
    assert "moves no mass: twist" in message


def test_published_carex_robot_has_the_expected_findings(
    shared: Path, cardsflow: CommandLine
) -> None:
    messages = find_messages(cardsflow, shared / "robots/caspr/CAREX")
    assert "joint_1_gamma" in messages["massless-motion"]


@pytest.mark.slow
def test_check_of_an_experiment_includes_its_settings(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    text = (PLANAR_2R / "experiment.toml").read_text()
    text = text.replace('"robot/', f'"{PLANAR_2R}/robot/')
    (tmp_path / "experiment.toml").write_text(text)
    for place in (tmp_path, tmp_path / "experiment.toml", PLANAR_2R / "experiment.toml"):
        assert find_messages(cardsflow, place) == {}
    weak = "".join(f"[muscles.cable_{k}]\nf_max = 15.0\n" for k in range(1, 5))
    (tmp_path / "experiment.toml").write_text(f"{text}\n{weak}")
    message = find_messages(cardsflow, tmp_path)["motion-not-held"]
    assert "points of the reference are infeasible within the force limits, from t = " in message
    assert "cardsflow size" in message
    assert "[zero-inertia-about-axis]" in cardsflow("check", tmp_path)[1]  # of the robot's files


@pytest.mark.slow
@pytest.mark.parametrize("name", ["roboy_left_arm", "hill_arm", "pick_up", "pneumatic_elbow"])
def test_examples_have_no_findings(name: str, cardsflow: CommandLine) -> None:
    assert find_messages(cardsflow, EXAMPLES / name / "experiment.toml") == {}
    assert find_messages(cardsflow, EXAMPLES / name / "robot") == {}


def test_check_rejects_an_invalid_experiment(tmp_path: Path, cardsflow: CommandLine) -> None:
    (tmp_path / "experiment.toml").write_text("[robot]\npath = 3\n")
    assert "robot.path" in cardsflow("check", tmp_path)[2]


def test_caspr_folder_with_an_experiment_is_checked_as_robot(
    tmp_path: Path, cardsflow: CommandLine
) -> None:
    write_caspr(arm(0.5, lower=-1.0, upper=1.0, initial=0.0), tmp_path)
    (tmp_path / "experiment.toml").write_text("nonsense")
    assert cardsflow("check", tmp_path)[0] == 0


@pytest.mark.parametrize(("joints", "muscles"), [(301, 1), (1, 2001)])
def test_drives_of_very_large_robots_are_not_checked(
    joints: int, muscles: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For a URDF of 1 MB with 3000 joints, the check would take more than 100 s."""
    robot = arm(1.0)
    more = range(1, joints)
    links = [Link(f"l{k}", LIGHT) for k in more]
    chain = [Joint(f"j{k}", WORLD, f"l{k}", revolute(Y), (Coordinate(f"q{k}"),)) for k in more]
    strands = tuple(replace(robot.muscles[0], name=f"m{k}") for k in range(muscles))
    robot = replace(
        robot, links=(*robot.links, *links), joints=(*robot.joints, *chain)
    ).with_muscles(strands)
    monkeypatch.setattr(drive_check, "control_dynamics", lambda *_, **__: pytest.fail("computed"))
    (finding,) = drive_check.drive_findings(robot)
    assert finding.code == "not-looked-at"
    with pytest.raises(InputError, match="more than 300 coordinates or 2000 muscles"):
        first_motion(robot)
