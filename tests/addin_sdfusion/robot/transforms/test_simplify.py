from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.random_robots import random_robot

from addin_sdfusion.robot import (
    IDENTITY,
    WORLD,
    BasePulley,
    Joint,
    Mesh,
    Pose,
    TaskFrame,
    TaskSet,
    ViaPoint,
    WrapSurface,
    align_frames,
    check,
    merge_fixed_joints,
    read_robot,
)
from addin_sdfusion.robot.model.rotations import apply, compose, inverse
from sim_dart import DartDynamics, MusclePaths

SEEDS = range(8)


def positions_only(robot):
    """Return the robot with only positions in its task frames; angles depend on link frames."""
    group = robot.task_sets[0]
    points = tuple(f for f in group.frames if set(f.axes) <= {"x", "y", "z"})
    return replace(robot, task_sets=(TaskSet(group.name, points),))


def assert_same_motion(one, other, seed):
    assert [c.name for c in one.coordinates] == [c.name for c in other.coordinates]
    assert [f for f in check(other) if f.is_error] == []
    a, b = DartDynamics(one), DartDynamics(other)
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1.0, 1.0, (2, a.n))
    for name in ("mass_matrix", "gravity", "muscle_lengths", "muscle_jacobian", "task_position"):
        close(getattr(a, name)(q), getattr(b, name)(q))
    close(a.coriolis(q, qd), b.coriolis(q, qd))
    close(a.task_jacobian(q), b.task_jacobian(q))
    close(a.task_bias(q, qd), b.task_bias(q, qd))


def close(one, other):
    np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-11 * max(1.0, np.abs(one).max()))


@pytest.mark.parametrize("seed", SEEDS)
def test_merging_only_changes_the_number_of_links(seed):
    robot = random_robot(seed)
    merged = merge_fixed_joints(robot)
    assert all(joint.motions for joint in merged.joints)
    assert len(merged.links) == len(robot.coordinates)
    assert_same_motion(robot, merged, seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_aligned_frames_are_parallel_to_the_world_without_other_changes(seed):
    robot = positions_only(random_robot(seed))
    aligned = align_frames(robot)
    for joint in aligned.joints:
        assert joint.T_child_joint == IDENTITY
        assert joint.T_parent_joint.rpy == (0.0, 0.0, 0.0)
    assert_same_motion(robot, aligned, seed)
    assert_same_motion(robot, align_frames(merge_fixed_joints(robot)), seed)


def zero_poses(robot):
    poses = {WORLD: IDENTITY}
    for joint in robot.joints:
        T_parent_child = compose(joint.T_parent_joint, inverse(joint.T_child_joint))
        poses[joint.child] = compose(poses[joint.parent], T_parent_child)
    return poses


def test_objects_on_a_link_move_with_it():
    robot = random_robot(3)
    links = tuple(
        replace(link, meshes=(Mesh("visual", link.name, Pose((0.1, 0.2, 0.3), (0.3, 0.2, 0.1))),))
        for link in robot.links
    )
    surfaces = tuple(WrapSurface(n.name, n.name, "sphere", 0.1, Pose((0.1, 0, 0))) for n in links)
    robot = replace(robot, links=links, wrap_surfaces=surfaces)
    before = zero_poses(robot)
    for simpler in (merge_fixed_joints(robot), align_frames(robot)):
        after = zero_poses(simpler)
        meshes = [(link, mesh) for link in simpler.links for mesh in link.meshes]
        assert len(meshes) == len(links)
        for link, mesh in meshes:
            expected = compose(before[mesh.uri], Pose((0.1, 0.2, 0.3), (0.3, 0.2, 0.1)))
            found = compose(after[link.name], mesh.pose)
            assert found.position == pytest.approx(expected.position, abs=1e-12)
        for surface in simpler.wrap_surfaces:
            expected = apply(before[surface.name], (0.1, 0, 0))
            found = apply(after[surface.link], surface.pose.position)
            assert found == pytest.approx(expected, abs=1e-12)


def weld(child, parent, rpy=(0.0, 0.0, 0.0)):
    return Joint(f"weld {child}", parent, child, (), (), Pose((0.1, 0.2, 0.3), rpy))


@pytest.mark.parametrize("axes", [("x",), ("alpha",)])
def test_link_with_a_task_frame_that_cannot_be_moved_is_kept(axes):
    robot = random_robot(1)
    tip, other = robot.links[0], robot.links[1]
    links = (*robot.links, replace(other, name="hand"), replace(other, name="rock"))
    joints = (*robot.joints, weld("hand", tip.name, (0.3, 0.0, 0.0)), weld("rock", WORLD))
    frames = (TaskFrame("h", "hand", axes=axes), TaskFrame("r", "rock", axes=axes))
    tasks = (TaskSet("both", frames),)
    robot = replace(robot, links=links, joints=joints, task_sets=tasks)
    merged = merge_fixed_joints(robot)
    stay = {joint.child for joint in merged.joints if not joint.motions}
    assert stay == ({"rock"} if axes == ("x",) else {"rock", "hand"})
    assert_same_motion(robot, merged, 1)


def test_pulley_turns_with_its_link():
    robot = random_robot(2)
    tip, muscle = robot.links[0].name, robot.muscles[0]
    base = replace(robot.links[0], name="base")
    entry = ("cable_entry_vector", (0.0, 0.6, 0.8))
    pulley = BasePulley("rotating", (("pulley_radius", (0.01,)), entry))
    points = (ViaPoint("base", (1.0, 2.0, 3.0)), ViaPoint(tip, (0.0, 0.0, 0.1)))
    over_pulley = replace(muscle, via_points=points, wraps=(), pulley=pulley)
    robot = replace(
        robot.with_muscles([over_pulley]),
        links=(*robot.links, base),
        joints=(*robot.joints, weld("base", WORLD, (0.3, -0.2, 0.5))),
    )
    q = np.random.default_rng(2).uniform(-1.0, 1.0, len(robot.coordinates))
    merged = merge_fixed_joints(robot)
    assert merged.muscles[0].via_points[0].link == WORLD
    close(MusclePaths(merged).evaluate(q).lengths, MusclePaths(robot).evaluate(q).lengths)


def test_links_fixed_to_the_world_become_world(shared):
    robot = merge_fixed_joints(read_robot(shared / "robots/cardsflow/msj_platform"))
    assert [link.name for link in robot.links] == ["top", "sphere_link1", "sphere_link2"]
    assert {muscle.via_points[0].link for muscle in robot.muscles} == {WORLD}


def test_merged_model_agrees_with_caspr(shared):
    """The CARDSFlow model and the model that CASPR made of it, rounded to four digits."""
    sdf = merge_fixed_joints(read_robot(shared / "robots/cardsflow/roboy_upper_body"))
    caspr = read_robot(shared / "robots/caspr/RoboyUpperBody")
    ours, theirs = DartDynamics(sdf), DartDynamics(caspr)
    children = [joint.child for joint in sdf.joints]
    columns = [children.index(joint.child) for joint in caspr.joints]
    assert sorted(columns) == list(range(26))
    rows = [ours.muscle_names.index(name) for name in theirs.muscle_names]
    q = np.zeros(26)
    lengths = ours.muscle_lengths(q)[rows]
    np.testing.assert_allclose(lengths, theirs.muscle_lengths(q), rtol=0, atol=1.2e-4)
    L = ours.muscle_jacobian(q)[np.ix_(rows, columns)]
    np.testing.assert_allclose(L, theirs.muscle_jacobian(q), rtol=0, atol=7e-5)
