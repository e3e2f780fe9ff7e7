"""Written SDF files pass the checker of libsdformat."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from lxml import etree
from support.robots.every_joint import every_joint
from support.robots.one_link import one_link
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Robot, read_robot, sdf_losses, write_sdf

CHECKER = shutil.which("ign")
DESCRIPTIONS = sorted(Path("/usr/share").glob("sdformat*/1.*"), key=lambda f: int(f.suffix[1:]))

pytestmark = pytest.mark.skipif(
    CHECKER is None, reason="libsdformat's checker is not installed: .ci/run installs it"
)


def verdict(folder):
    command = [str(CHECKER), "sdf", "-k", str(folder / "model.sdf")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    return done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "robot", [planar_2r(), random_robot(0), every_joint()], ids=lambda robot: str(robot.name)
)
def test_written_robots_are_valid(tmp_path, robot: Robot):
    write_sdf(robot, tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


def undeclared(element, description):
    """Return the paths of elements that the SDF schema of libsdformat does not contain."""
    declared = {}
    for child in description.iterchildren("element", "include"):
        if child.tag == "include":
            child = etree.parse(DESCRIPTIONS[-1] / child.get("filename")).getroot()
        declared[child.get("name")] = child
    for child in element.iterchildren():
        if child.tag not in declared:
            yield f"{element.tag}/{child.tag}"
        elif child.tag != "plugin":
            yield from undeclared(child, declared[child.tag])


def test_only_elements_of_the_newest_sdf_version_are_written(tmp_path):
    """Readers convert between versions, and Drake rejects unknown elements of the last one."""
    write_sdf(every_joint(), tmp_path)
    newest = etree.parse(DESCRIPTIONS[-1] / "root.sdf").getroot()
    assert not list(undeclared(etree.parse(tmp_path / "model.sdf").getroot(), newest))


@pytest.mark.slow
def test_numbers_that_cpp_readers_reject_are_written_as_zero(tmp_path):
    robot = one_link(friction=5e-324, initial=0.5)
    write_sdf(robot, tmp_path)
    assert "5e-324" not in (tmp_path / "model.sdf").read_text()
    assert "Valid." in verdict(tmp_path)
    assert read_robot(tmp_path) == replace(robot, joints=one_link(initial=0.5).joints)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["msj_platform", "musc-le", "test_robot"])
def test_published_robots_are_valid_after_repair(shared, tmp_path, name):
    robot = read_robot(shared / "robots/cardsflow" / name, repair=True)
    write_sdf(robot, tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["BMArm", "Example_planar_XY", "Example_spatial", "RoboyLeftArm"])
def test_caspr_models_are_valid_as_sdf(shared, tmp_path, name):
    write_sdf(read_robot(shared / "robots/caspr" / name), tmp_path)
    assert "Valid." in verdict(tmp_path), verdict(tmp_path)


@pytest.mark.slow
def test_inertia_that_the_checker_rejects_is_reported_before(shared, tmp_path):
    robot = read_robot(shared / "robots/cardsflow/msj_platform")
    write_sdf(robot, tmp_path)
    reported = [finding.subject.name for finding in sdf_losses(robot)]
    assert reported == ["top"]
    assert "A link named top has invalid inertia" in verdict(tmp_path)
