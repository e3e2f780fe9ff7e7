from __future__ import annotations

import math
import re
import tempfile
from dataclasses import replace

import mujoco
import numpy as np
import pytest
import trimesh
from hypothesis import assume, given
from support.oracles.mujoco_model import dense_tendon_jacobian
from support.robots.every_joint import every_joint
from support.robots.one_link import CASPR_ROBOTS, cable, one_link, round_a_circle
from support.robots.random_robots import random_robot, robots
from support.robots.robots import chain, planar_2r

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Mesh,
    Pose,
    Robot,
    RobotError,
    Wrap,
    WrapSurface,
    read_robot,
    revolute,
)
from addin_sdfusion.robot.formats.mjcf.capabilities import mjcf_losses
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from sim_dart import DartDynamics, Plant


def load(robot, folder, **options):
    (file,) = write_mjcf(robot, folder, "robot", **options)
    return mujoco.MjModel.from_xml_path(str(file))


def assert_equal_terms(robot, folder, states=5):
    model, ours = load(robot, folder), DartDynamics(robot)
    data = mujoco.MjData(model)
    order = [model.joint(name).dofadr[0] for name in ours.coordinate_names]
    assert [model.tendon(k).name for k in range(model.ntendon)] == list(ours.muscle_names)
    rng = np.random.default_rng(1)
    for _ in range(states):
        q, qd = rng.uniform(-2, 2, (2, ours.n))
        data.qpos[order], data.qvel[order] = q, qd
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        bias = ours.coriolis(q, qd) + ours.gravity(q)
        size = max(1.0, np.abs(bias).max(initial=0.0))
        close = {"rtol": 1e-9, "atol": 1e-9}
        np.testing.assert_allclose(M[np.ix_(order, order)], ours.mass_matrix(q), **close)
        theirs = (data.qfrc_bias - data.qfrc_spring)[order]
        np.testing.assert_allclose(theirs / size, bias / size, **close)
        np.testing.assert_allclose(data.ten_length, ours.muscle_lengths(q), **close)
        L = dense_tendon_jacobian(model, data)[:, order]
        np.testing.assert_allclose(L, ours.muscle_jacobian(q), **close)
    return model


@pytest.mark.parametrize("seed", range(5))
def test_random_tree_has_equal_dynamics_and_paths_in_mujoco(seed, tmp_path):
    assert_equal_terms(random_robot(seed, 8), tmp_path)


def test_all_caspr_joints_have_equal_dynamics_and_paths_in_mujoco(tmp_path):
    assert_equal_terms(every_joint(), tmp_path)


def test_long_chain_has_equal_dynamics_and_paths_in_mujoco(tmp_path):
    assert_equal_terms(chain(), tmp_path)


def test_arm_with_zero_moments_of_inertia_is_read_by_mujoco(tmp_path):
    assert_equal_terms(planar_2r(), tmp_path)
    reported = [f for f in mjcf_losses(planar_2r()) if f.code == "inertia-increased"]
    assert [f.subject.name for f in reported] == ["link_1", "link_2"]
    assert re.search(r"\de-14 kg·m² is added to each$", reported[0].message)


@pytest.mark.parametrize("name", CASPR_ROBOTS)
def test_published_robots_have_equal_dynamics_and_paths_in_mujoco(shared, name, tmp_path):
    assert_equal_terms(read_robot(shared / "robots/caspr" / name), tmp_path)


def next_to_origin(muscle):
    """Return whether MuJoCo merges a site within 1e-6 of the body origin with the origin."""
    return any(0.0 < math.hypot(*point.position) < 1e-5 for point in muscle.via_points)


@pytest.mark.slow
@given(robots())
def test_any_valid_robot_is_written(robot):
    assume(not any(map(next_to_origin, robot.muscles)))
    with tempfile.TemporaryDirectory() as folder:
        assert_equal_terms(robot, folder, 1)


def test_control_is_a_tension(tmp_path):
    robot = planar_2r()
    model = load(robot, tmp_path)
    data = mujoco.MjData(model)
    data.ctrl[:] = tensions = np.array([10.0, 20.0, 30.0, 40.0])
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(
        data.qfrc_actuator, -DartDynamics(robot).muscle_jacobian([0.0, 0.0]).T @ tensions
    )
    np.testing.assert_array_equal(model.actuator_ctrlrange, [[10.0, 100.0]] * 4)


def test_limits_damping_initial_values_and_motors_are_written(tmp_path):
    q = {"lower": -1.0, "upper": math.inf, "initial": 0.25, "damping": 0.5, "actuated": True}
    model = load(one_link(**q), tmp_path)
    assert model.jnt_limited.all()
    assert model.jnt_range.tolist() == [[-1.0, math.inf]]
    assert model.dof_damping.tolist() == [0.5]
    assert model.key("initial").qpos.tolist() == [0.25]
    assert model.actuator("q").trnid[0] == model.joint("q").id


def run(model, seconds):
    """Return positions and velocities after each step, from the initial values: (2, steps, n)."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    states = []
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
        states.append((data.qpos.copy(), data.qvel.copy()))
    return np.swapaxes(np.array(states), 0, 1)


def test_equal_limits_lock_the_coordinate(tmp_path):
    """A coordinate that begins 0.5 rad away reaches the value within some steps."""
    q, _ = run(load(one_link(lower=0.5, upper=0.5), tmp_path), 1.0)
    np.testing.assert_allclose(q[50:], 0.5, atol=1e-6)


ARM = Inertia(1.0, (0.5, 0.0, 0.0), 0.01, 0.01, 0.01)


def falling(**coordinate):
    """Return a rod on a hinge about the horizontal y axis, initially horizontal."""
    return one_link(ARM, motions=revolute((0.0, 1.0, 0.0)), **coordinate)


def test_joint_limit_is_exceeded_by_at_most_one_step_with_little_rebound(tmp_path):
    robot = falling(lower=-2.0, upper=1.0)
    model = load(robot, tmp_path)
    q, qd = run(model, 5.0)
    fastest = qd.max()
    assert fastest > 4.0
    assert 0.0 < q.max() - 1.0 < model.opt.timestep * fastest
    assert -0.03 * fastest < qd.min() < 0.0
    assert abs(q[-1, 0] - 1.0) < 1e-7
    assert "soft-stops" in {finding.code for finding in mjcf_losses(robot)}
    assert "soft-stops" not in {finding.code for finding in mjcf_losses(falling(lower=-math.inf))}


def test_coulomb_friction_holds_the_joint(tmp_path):
    """The torque of its weight is 4.9 N·m."""
    robot = falling(friction=5.0)
    q, _ = run(load(robot, tmp_path), 5.0)
    assert np.abs(q[-1] - q[0]).max() < 1e-7
    assert [f.code for f in mjcf_losses(robot) if f.code == "soft-friction"]
    assert "soft-friction" not in {finding.code for finding in mjcf_losses(falling())}


def with_stops(robot, friction, rng):
    """Return the tree without muscles and springs, with limits and friction in all joints."""
    joints = []
    for joint in robot.joints:
        words = {"initial": 0.0, "stiffness": 0.0, "damping": 0.05, "friction": friction}
        limits = {"lower": rng.uniform(-1, -0.1), "upper": rng.uniform(0.1, 1)}
        coordinates = tuple(replace(c, **limits, **words) for c in joint.coordinates)
        joints.append(replace(joint, coordinates=coordinates))
    return replace(robot, joints=tuple(joints), cable_sets=(), cable_set="")


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 10.0, 60.0])
@pytest.mark.parametrize("seed", [3, 5, 9])
def test_tree_with_limits_and_friction_moves_as_in_this_simulation(friction, seed, tmp_path):
    robot = with_stops(random_robot(seed, 6), friction, np.random.default_rng(seed))
    model, plant = load(robot, tmp_path), Plant(robot)
    order = [model.joint(c.name).dofadr[0] for c in robot.coordinates]
    theirs, ours = run(model, 3.0)[0][:, order], []
    for _ in theirs:
        plant.step(np.zeros(0))
        ours.append(plant.q.copy())
    assert np.abs(theirs - ours).max() < 1e-2
    if friction:
        assert np.abs(theirs[-1] - theirs[-500]).max() < 1e-8


@pytest.mark.parametrize(("f_min", "f_max"), [(5.0, 5.0), (5.0, math.inf)])
def test_equal_and_infinite_force_limits_are_written(f_min, f_max, tmp_path):
    muscle = cable((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), f_min=f_min, f_max=f_max)
    robot = one_link(muscles=[muscle])
    model = load(robot, tmp_path)
    codes = {finding.code for finding in mjcf_losses(robot)}
    assert bool(model.actuator_ctrllimited[0]) == (f_min < f_max)
    assert ("force-limits-left-out" in codes) == (f_min == f_max)
    again = read_robot(tmp_path / "robot.xml").muscles[0]
    assert (again.f_min, again.f_max) == ((f_min, f_max) if f_min < f_max else (0.0, math.inf))


@pytest.mark.parametrize(("low", "high"), [(-3.0, 5.0), (-math.inf, 5.0), (-math.inf, math.inf)])
def test_motor_limits_are_control_limits(low, high, tmp_path):
    model = load(one_link(actuated=True, tau_min=low, tau_max=high), tmp_path)
    limited = math.isfinite(low) or math.isfinite(high)
    assert bool(model.actuator_ctrllimited[0]) == limited
    if limited:
        assert model.actuator_ctrlrange.tolist() == [[low, high]]


def test_motor_limits_without_a_motor_are_reported():
    codes = {finding.code for finding in mjcf_losses(one_link(tau_min=-3.0))}
    assert "motor-bounds-left-out" in codes


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
@pytest.mark.parametrize("side", [1, -1, 0])
def test_tendon_wraps_on_the_chosen_side(shape, side, tmp_path):
    robot, length = round_a_circle(shape, side)
    model = load(robot, tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(length, abs=1e-9)
    assert ("side-by-place" in {f.code for f in mjcf_losses(robot)}) == bool(side)


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_tendon_wraps_inside_its_surface(shape, tmp_path):
    """From (-1, 0.6) to (1, 0.6) through a circle of radius 0.5 about the origin: via (0, 0.5)."""
    surface = WrapSurface("ring", WORLD, shape, 0.5, Pose((0.0, 0.0, 0.2), (0.0, 0.0, 1.0)))
    muscle = cable((-1.0, 0.6, 0.2), (1.0, 0.6, 0.2), wraps=(Wrap("ring", 0, inside=True),))
    robot = one_link(muscles=[muscle], surfaces=[surface])
    model = load(robot, tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(2 * math.hypot(1.0, 0.1), abs=1e-9)
    assert "side-by-place" not in {f.code for f in mjcf_losses(robot)}


def test_unsupported_wrapping_is_reported(tmp_path):
    surfaces = [WrapSurface("c", WORLD, "cylinder", 0.1, length=0.5)]
    surfaces += [WrapSurface("s", "a", "sphere", 0.1)]
    wraps = (Wrap("c", 0, 0, 1), Wrap("s", 0))
    muscle = cable((-1.0, 0.1, 0.2), (1.0, 0.1, 0.2), f_max=1.0, wraps=wraps)
    robot = one_link(muscles=[muscle], surfaces=surfaces)
    assert sorted(finding.code for finding in mjcf_losses(robot)) == [
        "cylinder-ends-left-out",
        "ends-move-near-wraps",
        "names-left-out",
        "names-left-out",
        "turns-left-out",
        "wrap-left-out",
    ]
    assert load(robot, tmp_path).geom("c").size[:2].tolist() == [0.1, 0.25]


def test_published_upper_body_is_rejected_for_its_inertias(shared, tmp_path):
    robot = read_robot(shared / "robots/caspr/RoboyUpperBody")
    with pytest.raises(RobotError, match="MuJoCo rejects a principal moment"):
        write_mjcf(robot, tmp_path)


def test_impossible_inertia_is_rejected(tmp_path):
    robot = one_link(Inertia(1.0, (0.1, 0.0, 0.0), 0.1, 0.1, 0.3))
    with pytest.raises(RobotError, match="link 'a': MuJoCo rejects a principal moment"):
        write_mjcf(robot, tmp_path / "new")
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    "inertia",
    [
        Inertia(1.0, (0.1, 0.0, 0.0)),
        Inertia(0.0, (0.1, 0.0, 0.0), 1.0, 1.0, 1.0),
        Inertia(1e-3, (1e-3, 0.0, 0.0), 1e-9, 1e-9, 0.0),
        Inertia(1e3, (0.1, 0.0, 0.0), 1e3, 1e3, 2e3),
    ],
)
def test_mujoco_accepts_increased_moments_of_inertia(inertia, tmp_path):
    model = load(one_link(inertia), tmp_path)
    assert model.body_mass[1] == pytest.approx(inertia.mass, abs=1e-11)
    moments = sorted((inertia.ixx, inertia.iyy, inertia.izz), reverse=True)
    np.testing.assert_allclose(model.body_inertia[1], moments, rtol=1e-11, atol=2e-14)
    codes = {finding.code for finding in mjcf_losses(one_link(inertia))}
    assert codes & {"inertia-increased", "mass-increased"}


def test_fixed_massless_link_has_no_inertial_in_mujoco(tmp_path):
    robot = one_link()
    links = (*robot.links, Link("b", Inertia(0.0)))
    robot = replace(robot, links=links, joints=(*robot.joints, Joint("f", "a", "b")))
    assert load(robot, tmp_path).body_mass.tolist() == [0.0, 1.0, 0.0]


def test_meshes_with_files_are_shown_without_collisions(tmp_path):
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    visual = Mesh("visual", "model://r/box.stl", Pose((1.0, 0.0, 0.0)), (0.1, 0.1, 0.1))
    meshes = (visual, replace(visual, role="collision"), replace(visual, uri="other.stl"))
    robot = one_link()
    robot = replace(robot, links=(replace(robot.links[0], meshes=meshes),))
    files = {visual.uri: tmp_path / "box.stl"}
    model = load(robot, tmp_path, meshes=files)
    assert (model.ngeom, model.geom_contype.any(), model.body_mass[1]) == (2, False, 1.0)
    codes = sorted(finding.code for finding in mjcf_losses(robot, files))
    assert codes == ["collisions-off", "mesh-left-out", *["names-left-out"] * 2]
    assert load(robot, tmp_path).ngeom == 0


def test_order_of_coordinates_in_mujoco_is_reported():
    robot = random_robot(2, 8)
    order = [f for f in mjcf_losses(robot) if f.code == "coordinate-order"]
    assert len(order) == 1
    assert "joint_7" in order[0].message
    assert not [f for f in mjcf_losses(chain()) if f.code == "coordinate-order"]


def serial(count):
    links = tuple(Link(str(k), Inertia(1.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)) for k in range(count))
    joints = tuple(
        Joint(
            f"j{k}",
            str(k - 1) if k else WORLD,
            str(k),
            revolute((1.0, 0, 0)),
            (Coordinate(str(k)),),
        )
        for k in range(count)
    )
    return Robot("serial", links, joints)


@pytest.mark.slow
def test_longest_chain_is_read_and_a_longer_one_is_rejected(tmp_path):
    assert load(serial(480), tmp_path).nv == 480
    with pytest.raises(RobotError, match="chains of at most 480 links"):
        write_mjcf(serial(481), tmp_path)


def test_omitted_features_are_reported():
    robot = planar_2r()
    first, *rest = robot.muscles
    robot = robot.with_muscles([replace(first, model=CableModel("linear_spring")), *rest])
    codes = {finding.code for finding in mjcf_losses(robot)}
    assert codes == {
        "inertia-increased",
        "cable-model-left-out",
        "task-axes-left-out",
        "cable-sets-left-out",
        "link-ends-left-out",
        "names-left-out",
        "soft-stops",
    }
