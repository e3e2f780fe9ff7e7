"""URDF: written files restore the robot, and third-party files agree with DART's reader."""

from __future__ import annotations

import tempfile
from pathlib import Path

import dartpy
import numpy as np
import pytest
from hypothesis import given
from support.robots.every_field import robot_of_every_field
from support.robots.random_robots import robots
from support.robots.robots import planar_2r
from support.third_party_models import URDF

from addin_sdfusion.robot import InputError, Robot, read_robot
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.formats.urdf.write import write_urdf
from addin_sdfusion.robot.transforms.simplify import joint_frames
from sim_dart import DartDynamics
from sim_dart.core.supported_features import require_supported_features


def of_text(folder: Path, text: str) -> Path:
    file = folder / "arm.urdf"
    file.write_text(text)
    return file


def test_third_party_arm_agrees_with_dart(tmp_path: Path) -> None:
    file = of_text(tmp_path, URDF)
    reading = read(file)
    robot = reading.require()
    codes = {finding.code for finding in reading.findings}
    assert codes >= {"welded-root", "unread-element", "missing-meshes"}
    assert [s.sizes for link in robot.links for s in link.shapes] == [(1.0, 1.0, 1.0)]
    assert robot.gravity == (0.0, 0.0, -1.6)
    slide = robot.joint("slide").coordinates[0]
    assert (slide.lower, slide.upper, slide.tau_max, slide.damping) == (-0.1, 0.2, 7.0, 0.3)
    assert (slide.friction, [c.name for c in robot.motors]) == (0.2, ["slide"])
    ours = DartDynamics(robot)
    plain = of_text(tmp_path, URDF.replace('<mesh filename="package://arm/a.stl"', "<box"))
    skeleton = dartpy.utils.DartLoader().parseSkeleton(str(plain))
    theirs = [skeleton.getDof(k).getName() for k in range(skeleton.getNumDofs())]
    order = [theirs.index(name) for name in ours.coordinate_names]
    root = 6  # DART adds a floating joint to the root
    assert len(theirs) == root + ours.n
    for q in np.random.default_rng(0).uniform(-1.0, 1.0, (5, ours.n)):
        positions = np.zeros(len(theirs))
        positions[order] = q
        skeleton.setPositions(positions)
        M = skeleton.getMassMatrix()[np.ix_(order, order)]
        np.testing.assert_allclose(ours.mass_matrix(q), M, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("robot", [planar_2r(), robot_of_every_field(1)], ids=lambda r: r.name)
def test_written_robots_are_restored_with_muscles(robot: Robot, tmp_path: Path) -> None:
    write_urdf(robot, tmp_path)
    assert read_robot(tmp_path) == joint_frames(robot)


@pytest.mark.slow
@given(robots())
def test_random_robots_are_restored(robot: Robot) -> None:
    with tempfile.TemporaryDirectory() as folder:
        file, *_ = write_urdf(robot, folder, "robot")
        assert read_robot(file) == joint_frames(robot)


def test_xacro_is_rejected_with_the_command_that_converts_it(tmp_path: Path) -> None:
    text = URDF.replace('name="arm">', 'name="arm" xmlns:xacro="http://ros.org/wiki/xacro">')
    assert read(of_text(tmp_path, text)).require()
    text = text.replace("<gazebo/>", '<xacro:arm prefix="a"/>')
    with pytest.raises(InputError, match=r"`xacro arm.urdf > arm.urdf`|is xacro"):
        read(of_text(tmp_path, text))


def test_robot_without_transmissions_has_motors_on_joints_with_effort(tmp_path: Path) -> None:
    bare = URDF.replace("<transmission", "<x").replace("</transmission>", "</x>")
    reading = read(of_text(tmp_path, bare))
    assert [c.name for c in reading.require().motors] == ["slide"]
    assert "motors-by-effort" in {finding.code for finding in reading.findings}


MIMIC = """<robot name="hand"><link name="palm"/>{links}
<joint name="a" type="revolute"><parent link="palm"/><child link="one"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="5" velocity="1"/></joint>
<joint name="b" type="revolute"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="5" velocity="1"/><mimic joint="a" multiplier="0.5"/></joint>
</robot>"""
LINKS = "".join(
    f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" '
    'ixz="0" iyz="0"/></inertial></link>'
    for name in ("one", "two")
)


def test_motor_of_a_mimic_joint_is_ignored_with_a_warning(tmp_path: Path) -> None:
    reading = read(of_text(tmp_path, MIMIC.format(links=LINKS)))
    assert [c.name for c in reading.require().motors] == ["a"]
    (finding,) = [f for f in reading.findings if f.code == "motor-left-out"]
    assert "coordinate 'b': follows another joint (<mimic>)" in finding.message


def test_motors_that_a_cardsflow_xml_removes_are_reported(tmp_path: Path) -> None:
    file = of_text(tmp_path, MIMIC.format(links=LINKS))
    (tmp_path / "cardsflow.xml").write_text("<cardsflow></cardsflow>")
    reading = read(file)
    assert reading.robot is not None
    assert reading.robot.motors == ()
    (finding,) = [f for f in reading.findings if f.code == "no-motors-by-effort"]
    assert "joints with an effort limit have no motor: 'a'" in finding.message


def test_friction_of_a_mimic_joint_is_applied_to_its_leading_joint(tmp_path: Path) -> None:
    """With the same power: 0.1 + 2 * 0.03 + 2 * 3 * 0.01 on the first joint."""
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    text = '<robot name="r"><link name="l0"/>'
    joints = ((0.1, ""), (0.03, ("j1", -2)), (0.01, ("j2", 3)))
    for k, (friction, leader) in enumerate(joints, 1):
        mimic = f'<mimic joint="{leader[0]}" multiplier="{leader[1]}"/>' if leader else ""
        text += (
            f'<link name="l{k}"><inertial><mass value="1"/>{inertia}</inertial></link>'
            f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
            f'<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="5" velocity="1"/>'
            f'<dynamics friction="{friction}"/>{mimic}</joint>'
        )
    file = tmp_path / "r.urdf"
    file.write_text(text + "</robot>")
    reading = read(file)
    frictions = [c.friction for c in reading.require().all_coordinates]
    assert frictions == [pytest.approx(0.22), 0.0, 0.0]
    require_supported_features(reading.require())
    assert "friction-of-mimic" in [finding.code for finding in reading.findings]
