"""What is written passes the checker of libsdformat."""

from __future__ import annotations

import shutil
import subprocess

import pytest
from support.robots.every_joint import every_joint
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Robot, read_robot, sdf_losses, write_sdf

CHECKER = shutil.which("ign")

pytestmark = pytest.mark.skipif(
    CHECKER is None, reason="libsdformat's checker is not installed: .ci/run installs it"
)


def verdict(folder):
    command = [str(CHECKER), "sdf", "-k", str(folder / "model.sdf")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    return done.stdout + done.stderr


@pytest.mark.parametrize(
    "robot", [planar_2r(), random_robot(0), every_joint()], ids=lambda robot: str(robot.name)
)
def test_written_robots_are_valid(tmp_path, robot: Robot):
    write_sdf(robot, tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


@pytest.mark.parametrize("name", ["msj_platform", "musc-le", "test_robot"])
def test_published_robots_are_valid_once_repaired(shared, tmp_path, name):
    robot = read_robot(shared / "robots/cardsflow" / name, repair=True)
    write_sdf(robot, tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


@pytest.mark.parametrize("name", ["BMArm", "Example_planar_XY", "Example_spatial", "RoboyLeftArm"])
def test_models_of_caspr_are_valid_as_sdf(shared, tmp_path, name):
    write_sdf(read_robot(shared / "robots/caspr" / name), tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


def test_an_inertia_that_the_checker_refuses_is_reported_before(shared, tmp_path):
    robot = read_robot(shared / "robots/cardsflow/msj_platform")
    write_sdf(robot, tmp_path)
    reported = [finding.subject.name for finding in sdf_losses(robot)]
    assert reported == ["top"]
    assert "A link named top has invalid inertia" in verdict(tmp_path)
