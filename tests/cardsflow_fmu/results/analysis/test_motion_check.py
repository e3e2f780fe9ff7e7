"""`cardsflow check --motion`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from support.command_line import CommandLine
from support.robots.robots import PLANAR_2R
from support.robots.worlds import two_link_arm

from addin_sdfusion.robot import WORLD, CableSet, Muscle, ViaPoint, write_sdf


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """Create a hanging arm with a muscle that swings into a cable."""
    arm = two_link_arm()
    swinging = Muscle("swinging", (ViaPoint("link_1", (0, 0, 0)), ViaPoint("link_2", (0, 0, -0.3))))
    standing = Muscle("standing", (ViaPoint(WORLD, (0.4, -1, 0.3)), ViaPoint(WORLD, (0.4, 1, 0.3))))
    write_sdf(replace(arm, cable_sets=(CableSet("all", (swinging, standing)),)), tmp_path / "arm")
    return tmp_path / "arm"


def findings(cardsflow: CommandLine, *words: object) -> list[dict[str, str]]:
    found = cardsflow.json("check", *words)
    return [f for f in found if f["code"].startswith("muscle-meets")]


def table(folder: Path, text: str) -> Path:
    (folder / "motion.csv").write_text(text)
    return folder / "motion.csv"


def test_collision_is_reported_with_bodies_distance_and_time(
    robot: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    motion = table(
        tmp_path, "time,q.joint_1,q.joint_2\n0,0,0\n0.5,-0.7853981633974483,0\n1,-1.2,0\n"
    )
    found = findings(cardsflow, robot, "--motion", motion, "--clearance", "1e-6")
    (meeting,) = [f for f in found if f["code"] == "muscle-meets-muscle"]
    assert meeting["severity"] == "warning"
    assert meeting["kind"] == "muscle"
    assert "'swinging'" in meeting["message"]
    assert "'standing'" in meeting["message"]
    assert "at t = 0.5 s" in meeting["message"]


def test_check_without_a_motion_finds_no_collisions(robot: Path, cardsflow: CommandLine) -> None:
    assert findings(cardsflow, robot) == []


def test_distant_bodies_have_no_finding(
    robot: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    motion = table(tmp_path, "joint_1,joint_2\n0,0\n")
    assert findings(cardsflow, robot, "--motion", motion) == []
    near = findings(cardsflow, robot, "--motion", motion, "--clearance", "0.5")
    assert "at joint_1 = 0 rad, joint_2 = 0 rad" in near[0]["message"]


def test_capsules_replace_links_on_request(
    robot: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    motion = table(tmp_path, "joint_1,joint_2\n-0.7853981633974483,0\n")
    found = findings(cardsflow, robot, "--motion", motion, "--capsules", "0.05")
    messages = [f["message"] for f in found if f["code"] == "muscle-meets-link"]
    assert any("50 mm deep through link 'link_2'" in message for message in messages)


@pytest.mark.slow
def test_random_postures_are_reproducible(robot: Path, cardsflow: CommandLine) -> None:
    first = findings(cardsflow, robot, "--motion", "random", "--clearance", "0.05")
    assert first
    assert findings(cardsflow, robot, "--motion", "random", "--clearance", "0.05") == first


@pytest.mark.slow
def test_trajectory_in_the_robot_folder_is_checked(cardsflow: CommandLine) -> None:
    """The cables of the planar arm are in one plane, so that cables 1 and 2 cross."""
    found = findings(
        cardsflow, PLANAR_2R / "robot", "--motion", "simple_joint_motion", "--clearance", "1"
    )
    assert found
    assert all("at t = " in f["message"] for f in found)


BAD = {
    "name": ("nonsense", "neither 'random' nor a .csv"),
    "missing": ("none.csv", "none.csv: cannot be read"),
}


@pytest.mark.parametrize("case", BAD)
def test_invalid_motion_of_a_check_is_reported_in_one_line(
    case: str, robot: Path, cardsflow: CommandLine
) -> None:
    motion, message = BAD[case]
    assert message in cardsflow.error_line("check", robot, "--motion", motion)


BAD_TABLES = {
    "column": ("time,q.joint_1\n0,0\n", "no column 'q.joint_2'"),
    "text": (
        "joint_1,joint_2\n0,x\n",
        "motion.csv: is not a table of joint positions: could not convert",
    ),
    "short": ("joint_1,joint_2\n0\n", "the rows have 1 numbers"),
    "nan": ("joint_1,joint_2\n0,nan\n", "not finite"),
    "empty": ("joint_1,joint_2\n", "has no rows"),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_invalid_motion_table_is_reported_in_one_line(
    case: str, robot: Path, tmp_path: Path, cardsflow: CommandLine
) -> None:
    text, message = BAD_TABLES[case]
    assert message in cardsflow.error_line("check", robot, "--motion", table(tmp_path, text))


def test_invalid_collision_options_are_rejected(robot: Path, cardsflow: CommandLine) -> None:
    random = ("check", robot, "--motion", "random")
    assert "--clearance: must be finite and not negative" in cardsflow.error_line(
        *random, "--clearance", "-1"
    )
    assert "capsule_radius must be above 0" in cardsflow.error_line(*random, "--capsules", "0")
    words = ("check", PLANAR_2R / "robot", "--motion", "simple_motion")
    assert "no trajectory 'simple_motion'" in cardsflow.error_line(*words)
