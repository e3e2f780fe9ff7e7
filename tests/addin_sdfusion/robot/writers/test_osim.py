from __future__ import annotations

import math
import tempfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from support.oracles.opensim_model import OpenSimRobot, load, opensim
from support.robots.every_joint import every_joint
from support.robots.one_link import CASPR_ROBOTS, cable, one_link, round_a_circle
from support.robots.random_robots import random_robot, robots
from support.robots.robots import chain, planar_2r

from addin_sdfusion.robot import (
    WORLD,
    Inertia,
    Joint,
    Link,
    Mesh,
    Pose,
    Wrap,
    WrapSurface,
    read_robot,
)
from addin_sdfusion.robot.formats.opensim.capabilities import osim_losses
from addin_sdfusion.robot.formats.opensim.write import write_osim
from sim_dart import DartDynamics


def actuator(model, name):
    return opensim.PathActuator.safeDownCast(model.getForceSet().get(name))


def assert_equal_terms(robot, folder, states=3):
    theirs, ours = OpenSimRobot(robot, folder), DartDynamics(robot)
    rng = np.random.default_rng(1)
    close = {"rtol": 1e-9, "atol": 1e-9}
    for _ in range(states):
        q, qd = rng.uniform(-1.5, 1.5, (2, ours.n))
        theirs.move(q, qd)
        bias = ours.coriolis(q, qd) + ours.gravity(q)
        size = max(1.0, np.abs(bias).max(initial=0.0))
        np.testing.assert_allclose(theirs.mass_matrix, ours.mass_matrix(q), **close)
        np.testing.assert_allclose(theirs.lengths, ours.muscle_lengths(q), **close)
        np.testing.assert_allclose(theirs.moment_arms, -ours.muscle_jacobian(q), **close)
        undamped = theirs.bias - ours.damping * qd
        np.testing.assert_allclose(undamped / size, bias / size, **close)


@pytest.mark.parametrize("seed", range(3))
def test_random_tree_has_equal_dynamics_and_paths_in_opensim(seed, tmp_path):
    assert_equal_terms(random_robot(seed, 8), tmp_path)


def test_all_caspr_joints_have_equal_dynamics_and_paths_in_opensim(tmp_path):
    assert_equal_terms(every_joint(), tmp_path)


def test_chain_has_equal_dynamics_and_paths_in_opensim(tmp_path):
    assert_equal_terms(chain(8, 10), tmp_path)


def test_arm_with_zero_moments_of_inertia_is_read_by_opensim(tmp_path):
    assert_equal_terms(planar_2r(), tmp_path)


@pytest.mark.parametrize("name", [*CASPR_ROBOTS, "RoboyUpperBody"])
def test_published_robots_have_equal_dynamics_and_paths_in_opensim(shared, name, tmp_path):
    assert_equal_terms(read_robot(shared / "robots/caspr" / name), tmp_path)


@given(robots())
def test_any_valid_robot_is_written(robot):
    with tempfile.TemporaryDirectory() as folder:
        assert_equal_terms(robot, folder, 1)


def test_control_is_a_tension(tmp_path):
    robot = planar_2r()
    theirs, ours = OpenSimRobot(robot, tmp_path), DartDynamics(robot)
    tensions = np.array([10.0, 20.0, 30.0, 40.0])
    theirs.move([0.1, 0.2], [0.0, 0.0])
    theirs.model.setControls(theirs.state, opensim.Vector.createFromMat(tensions))
    theirs.model.markControlsAsValid(theirs.state)
    pulled = theirs.bias
    expected = ours.gravity([0.1, 0.2]) + ours.muscle_jacobian([0.1, 0.2]).T @ tensions
    np.testing.assert_allclose(pulled, expected, atol=1e-9)
    muscles = [actuator(theirs.model, muscle.name) for muscle in robot.muscles]
    assert [(m.getMinControl(), m.getMaxControl()) for m in muscles] == [(10.0, 100.0)] * 4


def test_limits_damping_initial_values_and_motors_are_written(tmp_path):
    q = {"lower": -1.0, "upper": math.inf, "initial": 0.25, "damping": 0.5}
    q |= {"actuated": True, "tau_min": -3.0, "tau_max": 5.0}
    model, state = load(one_link(**q), tmp_path)
    c = model.getCoordinateSet().get("q")
    assert (c.getRangeMin(), c.getRangeMax(), c.getValue(state)) == (-1.0, math.inf, 0.25)
    forces = model.getForceSet()
    motor = opensim.CoordinateActuator.safeDownCast(forces.get("q_motor"))
    assert motor.getOptimalForce() == 1.0
    assert (motor.getMinControl(), motor.getMaxControl()) == (-3.0, 5.0)
    damper = opensim.SpringGeneralizedForce.safeDownCast(forces.get("q_damping"))
    assert damper.getViscosity() == 0.5
    assert "limits-are-ranges" in {finding.code for finding in osim_losses(one_link(**q))}


@pytest.mark.parametrize("initial", [0.25, 3.0])
def test_initial_values_outside_the_limits_are_kept(initial, tmp_path):
    model, state = load(one_link(lower=-1.0, upper=1.0, initial=initial), tmp_path)
    assert model.getCoordinateSet().get("q").getValue(state) == initial


def test_equal_limits_lock_the_coordinate(tmp_path):
    model, state = load(one_link(lower=0.5, upper=0.5), tmp_path)
    c = model.getCoordinateSet().get("q")
    assert (c.getLocked(state), c.getValue(state)) == (True, 0.5)


def test_infinite_force_limit_stays_infinite(tmp_path):
    muscle = cable((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), f_min=5.0)
    theirs = OpenSimRobot(one_link(muscles=[muscle]), tmp_path)
    assert actuator(theirs.model, "m").getMaxControl() == math.inf


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("side", [1, -1, 0])
def test_path_wraps_on_the_chosen_side(shape, side, tmp_path):
    robot, length = round_a_circle(shape, side)
    assert OpenSimRobot(robot, tmp_path).lengths[0] == pytest.approx(length, abs=1e-5)
    codes = {finding.code for finding in osim_losses(robot)}
    assert ("side-by-place" in codes) == bool(side)
    assert ("cylinder-has-ends" in codes) == (shape == "cylinder")


def test_wrap_inside_a_surface_is_omitted_with_a_finding(tmp_path):
    surface = WrapSurface("ring", WORLD, "sphere", 0.5)
    muscle = cable((-1.0, 0.6, 0.0), (1.0, 0.6, 0.0), wraps=(Wrap("ring", 0, inside=True),))
    robot = one_link(muscles=[muscle], surfaces=[surface])
    assert OpenSimRobot(robot, tmp_path).lengths[0] == pytest.approx(2.0, abs=1e-12)
    assert "wrap-left-out" in {finding.code for finding in osim_losses(robot)}


def test_massless_body_keeps_its_inertia(tmp_path):
    robot = one_link(Inertia(0.0, (0.1, 0.0, 0.0), 1.0, 1.0, 1.0))
    assert_equal_terms(robot, tmp_path)
    assert "mass-increased" in {finding.code for finding in osim_losses(robot)}


@pytest.mark.parametrize("on", ["a", WORLD])
def test_fixed_massless_links_are_read(on, tmp_path):
    robot = one_link()
    links = (*robot.links, Link("b", Inertia(0.0)))
    assert_equal_terms(
        replace(robot, links=links, joints=(*robot.joints, Joint("f", on, "b"))), tmp_path
    )


def test_meshes_are_shown_at_their_pose(tmp_path):
    mesh = Mesh("visual", "a.stl", scale=(0.1, 0.1, 0.1))
    placed = replace(mesh, pose=Pose((1.0, 0.0, 0.0), (0.1, 0.2, 0.3)))
    robot = one_link()
    meshes = (mesh, placed, replace(mesh, role="collision"))
    robot = replace(robot, links=(replace(robot.links[0], meshes=meshes),))
    model, state = load(robot, tmp_path, meshes={"a.stl": "b.stl"})
    frame = opensim.PhysicalOffsetFrame.safeDownCast(model.getComponent("/bodyset/a/mesh_frame_1"))
    offset = frame.getTransformInGround(state).p()
    assert offset.to_numpy().tolist() == [1.0, 0.0, 0.0]
    (file,) = write_osim(robot, tmp_path)
    assert [m.text for m in ElementTree.parse(file).iter("mesh_file")] == ["a.stl"] * 2
    assert "collisions-left-out" in {finding.code for finding in osim_losses(robot)}


def test_task_frames_become_markers(tmp_path):
    robot = random_robot(1)
    model, state = load(robot, tmp_path)
    for coordinate in robot.coordinates:
        model.getCoordinateSet().get(coordinate.name).setValue(state, 0.3)
    hand = model.getMarkerSet().get("hand").getLocationInGround(state).to_numpy()
    y = DartDynamics(robot).task_position([0.3] * len(robot.coordinates))
    np.testing.assert_allclose(hand, y[:3], atol=1e-12)


def test_names_that_opensim_rejects_are_changed_with_a_finding(tmp_path):
    robot = one_link()
    links = [replace(robot.links[0], name=name) for name in ("a b", "a_b", "ground", "..")]
    joints = [Joint(f"f{k}", "a b", link.name) for k, link in enumerate(links[1:])]
    first = replace(robot.joints[0], child="a b")
    robot = replace(robot, links=tuple(links), joints=(first, *joints))
    assert_equal_terms(robot, tmp_path)
    reported = [f.message for f in osim_losses(robot) if f.code == "renamed"]
    assert reported == [
        "link 'ground': OpenSim does not allow this name; written as 'ground_'",
        "link 'a b': OpenSim does not allow this name; written as 'a_b_'",
        "link '..': OpenSim does not allow this name; written as '_'",
    ]


def test_omitted_features_are_reported():
    codes = {finding.code for finding in osim_losses(planar_2r())}
    assert codes == {
        "limits-are-ranges",
        "task-axes-left-out",
        "cable-sets-left-out",
        "link-ends-left-out",
        "names-left-out",
    }
