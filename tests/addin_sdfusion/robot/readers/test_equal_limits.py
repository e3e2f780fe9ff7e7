"""Joints with equal limits are read as locked joints, from every format."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.robots.one_link import one_link

from addin_sdfusion.robot import Robot, revolute, write_caspr, write_sdf
from addin_sdfusion.robot.formats.opensim.write import write_osim
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.urdf.write import write_urdf
from addin_sdfusion.robot.model.link_poses import link_poses


def unlock(file: Path) -> None:
    """Replace the lock, which OpenSim needs, by equal limits alone."""
    text = file.read_text("utf-8").replace("<locked>true<", "<locked>false<")
    file.write_text(text, "utf-8")


@pytest.mark.parametrize("limit", [0.0, 0.3])
@pytest.mark.parametrize("form", ["sdf", "caspr", "urdf", "osim"])
def test_equal_limits_lock_the_joint_at_the_limit(form: str, limit: float, tmp_path: Path) -> None:
    robot = one_link(motions=revolute((0.0, 1.0, 0.0)), lower=limit, upper=limit, initial=limit)
    writers = {"sdf": write_sdf, "caspr": write_caspr, "urdf": write_urdf, "osim": write_osim}
    writers[form](robot, tmp_path)
    for file in tmp_path.glob("*.osim"):
        unlock(file)
    reading = read(tmp_path)
    assert reading.robot is not None
    assert [c.name for c in reading.robot.coordinates] == []
    (finding,) = [f for f in reading.findings if f.code == "locked-by-limits"]
    assert finding.file is not None
    assert "read as locked" in finding.message
    assert orientation(reading.robot) == pytest.approx(orientation(robot), abs=1e-12)


def orientation(robot: Robot) -> tuple[float, ...]:
    return link_poses(robot, {c.name: c.lower for c in robot.coordinates})["a"].rpy


def test_invalid_robots_are_not_changed(tmp_path: Path) -> None:
    model = write_sdf(one_link(lower=0.0, upper=0.0, damping=1.0), tmp_path)[0]
    text = model.read_text("utf-8")
    assert "<damping>1.0<" in text
    model.write_text(text.replace("<damping>1.0<", "<damping>-1.0<"), "utf-8")
    codes = {f.code for f in read(tmp_path).findings}
    assert "negative-damping" in codes
    assert "locked-by-limits" not in codes
