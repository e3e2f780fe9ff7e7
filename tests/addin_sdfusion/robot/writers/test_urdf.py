from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from xml.etree import ElementTree

import dartpy
import numpy as np
import pytest
from hypothesis import given
from support.robots.every_joint import every_joint
from support.robots.one_link import CASPR_ROBOTS, one_link
from support.robots.random_robots import random_robot, robots
from support.robots.robots import planar_2r

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Mesh,
    Motion,
    Pose,
    Robot,
    RobotError,
    prismatic,
    read_robot,
    revolute,
)
from addin_sdfusion.robot.formats.urdf.capabilities import URDF
from addin_sdfusion.robot.formats.urdf.write import write_urdf
from addin_sdfusion.robot.transforms.joint_chains import single_joints
from sim_dart import DartDynamics


def load(robot, folder):
    file, *_ = write_urdf(robot, folder, "robot")
    skeleton = dartpy.utils.DartLoader().parseSkeleton(str(file))
    assert skeleton is not None
    return skeleton


def assert_equal_mass_matrices(robot, folder, states=5):
    skeleton, ours = load(robot, folder), DartDynamics(robot)
    names = [skeleton.getDof(k).getName() for k in range(skeleton.getNumDofs())]
    order = [names.index(name) for name in ours.coordinate_names]
    assert sorted(names) == sorted(ours.coordinate_names)
    rng = np.random.default_rng(1)
    for _ in range(states):
        q = rng.uniform(-2, 2, ours.n)
        theirs = np.zeros(ours.n)
        theirs[order] = q
        skeleton.setPositions(theirs)
        M, expected = skeleton.getMassMatrix()[np.ix_(order, order)], ours.mass_matrix(q)
        np.testing.assert_allclose(M, expected, rtol=1e-9, atol=1e-9)
    return skeleton


@pytest.mark.parametrize("seed", range(5))
def test_random_tree_has_equal_mass_matrix_in_dart(seed, tmp_path):
    assert_equal_mass_matrices(random_robot(seed, 8), tmp_path)


def test_all_caspr_joints_have_equal_mass_matrix_in_dart(tmp_path):
    robot = every_joint()
    assert_equal_mass_matrices(robot, tmp_path)
    chained = {f.subject.name for f in URDF.losses(robot) if f.code == "joint-in-a-chain"}
    assert chained == {j.name for j in robot.joints if len(j.motions) > 1}


@pytest.mark.parametrize("name", [*CASPR_ROBOTS, "RoboyUpperBody"])
def test_published_robots_have_equal_mass_matrix_in_dart(shared, name, tmp_path):
    assert_equal_mass_matrices(read_robot(shared / "robots/caspr" / name), tmp_path)


@pytest.mark.slow
@given(robots())
def test_any_valid_robot_is_written(robot):
    with tempfile.TemporaryDirectory() as folder:
        assert_equal_mass_matrices(robot, folder, 1)
        assert not any(finding.is_error for finding in URDF.losses(robot))


def test_limits_and_damping_are_written(tmp_path):
    limited = one_link(lower=-1.0, upper=0.5, damping=0.25)
    dof = load(limited, tmp_path).getDof(0)
    assert (dof.getPositionLowerLimit(), dof.getPositionUpperLimit()) == (-1.0, 0.5)
    assert dof.getDampingCoefficient() == 0.25


@pytest.mark.parametrize(
    ("motions", "limits", "kind"),
    [
        (revolute((0.0, 0.0, 1.0)), {}, "continuous"),
        (revolute((0.0, 0.0, 1.0)), {"lower": 0.0}, "revolute"),
        (prismatic((0.0, 0.0, 1.0)), {}, "prismatic"),
    ],
)
def test_joint_type_follows_from_motion_and_limits(motions, limits, kind, tmp_path):
    file, *_ = write_urdf(one_link(motions=motions, **limits), tmp_path)
    joint = ElementTree.parse(file).find("joint")
    assert (file.name, joint.get("type"), joint.get("name")) == ("r.urdf", kind, "q")
    assert (joint.find("limit") is None) == (kind == "continuous")


def test_meshes_are_relative_to_the_joint_frame(tmp_path):
    mesh = Mesh("visual", "package://r/a.stl", Pose((1.0, 0.0, 0.0)), (0.001,) * 3, "shell")
    robot = one_link()
    link = replace(robot.links[0], meshes=(mesh, replace(mesh, role="collision", name="")))
    joint = replace(robot.joints[0], T_child_joint=Pose((0.25, 0.0, 0.0)))
    file, *_ = write_urdf(replace(robot, links=(link,), joints=(joint,)), tmp_path)
    root = ElementTree.parse(file)
    assert root.find("link/visual").get("name") == "shell"
    assert root.find("link/visual/origin").get("xyz") == "0.75 0.0 0.0"
    shape = root.find("link/collision/geometry/mesh")
    assert (shape.get("filename"), shape.get("scale")) == (mesh.uri, "0.001 0.001 0.001")


def test_fixed_joint_is_renamed_if_a_coordinate_has_its_name(tmp_path):
    robot = one_link()
    fixed = (Link("b", Inertia(1.0)), Joint("q", "a", "b"))
    robot = replace(robot, links=(*robot.links, fixed[0]), joints=(*robot.joints, fixed[1]))
    file, *_ = write_urdf(robot, tmp_path)
    assert [j.get("name") for j in ElementTree.parse(file).iter("joint")] == ["q", "q_"]
    assert "renamed" in {finding.code for finding in URDF.losses(robot)}


def test_massless_link_is_renamed_if_a_link_has_its_name():
    turns = (Motion("rotation", (1.0, 0.0, 0.0)), Motion("rotation", (0.0, 1.0, 0.0), 1))
    joint = Joint("j", WORLD, "j_1", turns, (Coordinate("a"), Coordinate("b")))
    robot = Robot("r", (Link("j_1", Inertia(1.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)),), (joint,))
    assert [single.child for single in single_joints(robot)] == ["j_1_", "j_1"]


def test_unsupported_features_of_urdf_are_reported():
    robot = planar_2r()
    assert {finding.code for finding in URDF.losses(robot)} == {"held-beside-urdf"}
    other = one_link(lower=0.0, initial=1.0, actuated=True, stiffness=1.0)
    codes = {finding.code for finding in URDF.losses(other)}
    assert codes == {"held-beside-urdf", "one-sided-limit"}


@pytest.mark.parametrize("limits", [{"lower": -1.0, "upper": 1.0}, {}])
@pytest.mark.parametrize(("least", "written"), [(-5.0, 5.0), (-7.0, 7.0), (-math.inf, 1e16)])
def test_motor_limits_are_the_effort(least, written, limits, tmp_path):
    robot = one_link(actuated=True, tau_min=least, tau_max=5.0, **limits)
    file, *_ = write_urdf(robot, tmp_path)
    limit = ElementTree.parse(file).find("joint/limit")
    assert (1e16 if limit is None else float(limit.get("effort"))) == written
    assert ElementTree.parse(file).find("transmission/joint").get("name") == "q"
    (motor,) = read_robot(file).motors
    assert (motor.tau_min, motor.tau_max) == (least, 5.0)


def test_invalid_robot_is_not_written(tmp_path):
    with pytest.raises(RobotError, match="axis is zero"):
        write_urdf(one_link(motions=revolute((0.0, 0.0, 0.0))), tmp_path / "new")
    assert not (tmp_path / "new").exists()
