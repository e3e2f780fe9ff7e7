"""Several robots combined into one behave like the separate robots."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    CableSet,
    InputError,
    Mesh,
    Pose,
    Robot,
    Wrap,
    WrapSurface,
    check,
)
from addin_sdfusion.robot.model.rotations import apply, rotate, rotation
from addin_sdfusion.robot.transforms.combine import Member, combine
from sim_dart import DartDynamics, MusclePaths

MOVED = Pose((1.0, -2.0, 0.5), (0.3, -0.4, 0.7))


def pair(seed: int, pose: Pose = MOVED) -> tuple[Robot, Robot, Robot]:
    """Return two random robots, and both combined, the second one displaced."""
    one, other = random_robot(seed), random_robot(seed + 100, joints=4, muscles=5)
    return one, other, combine("both", [Member("one", one), Member("other", other, pose)])


@pytest.mark.parametrize("seed", range(5))
def test_combined_muscles_equal_separate_muscles(seed: int) -> None:
    """Lengths and Jacobians equal those of the separate robots, in any pose."""
    one, other, both = pair(seed)
    q = np.random.default_rng(seed).uniform(-1, 1, len(both.coordinates))
    n, m = len(one.coordinates), len(one.muscles)
    paths = MusclePaths(both)
    whole = paths.evaluate(q)
    for robot, columns, rows in (
        (one, slice(0, n), slice(0, m)),
        (other, slice(n, None), slice(m, None)),
    ):
        own = MusclePaths(robot)
        alone = own.evaluate(q[columns])
        np.testing.assert_allclose(whole.lengths[rows], alone.lengths, atol=1e-13)
        np.testing.assert_allclose(whole.jacobian[rows, columns], alone.jacobian, atol=1e-13)
    np.testing.assert_array_equal(whole.jacobian[:m, n:], 0.0)
    np.testing.assert_array_equal(whole.jacobian[m:, :n], 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_combined_dynamics_equal_separate_dynamics(seed: int) -> None:
    """The robots are rotated only about the vertical, so that gravity does not change."""
    one, other, both = pair(seed, Pose((1.0, -2.0, 0.5), (0.0, 0.0, 0.7)))
    rng = np.random.default_rng(seed)
    q, qd = rng.uniform(-1, 1, (2, len(both.coordinates)))
    n = len(one.coordinates)
    whole = DartDynamics(both)
    M, C, G = whole.mass_matrix(q), whole.coriolis(q, qd), whole.gravity(q)
    for robot, part in ((one, slice(0, n)), (other, slice(n, None))):
        alone = DartDynamics(robot)
        np.testing.assert_allclose(M[part, part], alone.mass_matrix(q[part]), atol=1e-12)
        np.testing.assert_allclose(C[part], alone.coriolis(q[part], qd[part]), atol=1e-11)
        np.testing.assert_allclose(G[part], alone.gravity(q[part]), atol=1e-11)
    np.testing.assert_allclose(M[:n, n:], 0.0, atol=1e-14)


@pytest.mark.parametrize("seed", range(3))
def test_task_points_move_with_the_robots(seed: int) -> None:
    _, other, both = pair(seed)
    q = np.random.default_rng(seed).uniform(-1, 1, len(both.coordinates))
    alone = MusclePaths(other).task_position(q[len(both.coordinates) - len(other.coordinates) :])
    whole = MusclePaths(both).task_position(q)[-len(alone) :]
    x, y, z = alone[:3].tolist()  # the frame `hand`
    np.testing.assert_allclose(whole[:3], apply(MOVED, (x, y, z)), atol=1e-13)


def test_names_begin_with_the_robot_name() -> None:
    arm = planar_2r()
    both = combine("pair", [Member("left", arm), Member("right", arm, Pose((3.0, 0.0, 0.0)))])
    assert [c.name for c in both.coordinates] == [
        "left_joint_1",
        "left_joint_2",
        "right_joint_1",
        "right_joint_2",
    ]
    assert [m.name for m in both.muscles][:2] == ["left_cable_1", "left_cable_2"]
    assert {j.parent for j in both.joints} == {WORLD, "left_link_1", "right_link_1"}
    assert not [f for f in check(both) if f.is_error]


def test_objects_fixed_to_the_world_move_with_the_robot() -> None:
    arm = planar_2r()
    surface = WrapSurface("peg", WORLD, "cylinder", 0.05, Pose((0.1, 0.0, 0.2)))
    on_link = WrapSurface("ball", "link_1", "sphere", 0.02)
    pulley = BasePulley("rotating", (("cable_entry_vector", (0.0, 0.0, 1.0)),))
    first = replace(arm.muscles[0], wraps=(Wrap("peg", 0),), pulley=pulley)
    robot = replace(arm.with_muscles([first, *arm.muscles[1:]]), wrap_surfaces=(surface, on_link))
    both = combine("b", [Member("a", arm), Member("b", robot, MOVED)])
    peg, ball = both.wrap_surfaces
    assert peg.pose.position == pytest.approx(apply(MOVED, (0.1, 0.0, 0.2)))
    assert peg.link == WORLD
    assert ball == replace(on_link, name="b_ball", link="b_link_1")
    muscle = both.muscle("b_cable_1")
    assert muscle.wraps == (Wrap("b_peg", 0),)
    assert muscle.pulley is not None
    turned = rotate(rotation(MOVED.rpy), (0.0, 0.0, 1.0))
    assert dict(muscle.pulley.parameters)["cable_entry_vector"] == pytest.approx(turned)


def test_meshes_are_found_relative_to_each_robot(tmp_path: Path) -> None:
    arm = planar_2r()
    links = (replace(arm.links[0], meshes=(Mesh("collision", "meshes/a.stl"),)), arm.links[1])
    robot = replace(arm, links=links)
    folders = [tmp_path / name for name in "xy"]
    both = combine("b", [Member(f.name, robot, folder=f) for f in folders])
    uris = [mesh.uri for link in both.links for mesh in link.meshes]
    assert uris == [str(folder / "meshes/a.stl") for folder in folders]
    kept = combine("b", [Member("x", robot)])
    assert kept.links[0].meshes == links[0].meshes


def test_robots_without_muscles_and_tasks_are_combined() -> None:
    bare = replace(planar_2r(), cable_sets=(), cable_set="", task_sets=(), task_set="")
    both = combine("b", [Member("a", bare), Member("b", bare)])
    assert both.muscles == ()
    assert both.task_frames == ()
    mixed = combine("b", [Member("a", bare), Member("b", planar_2r())])
    assert len(mixed.muscles) == 4


def test_parts_with_equal_names_are_rejected() -> None:
    arm = planar_2r()
    with pytest.raises(InputError, match="two robots would have the name 'a'"):
        combine("b", [Member("a", arm), Member("a", arm)])
    tricky = replace(
        arm,
        links=tuple(replace(link, name=f"b_{link.name}") for link in arm.links),
        joints=tuple(
            replace(
                joint,
                parent=joint.parent if joint.parent == WORLD else f"b_{joint.parent}",
                child=f"b_{joint.child}",
            )
            for joint in arm.joints
        ),
        cable_sets=(CableSet("none", ()),),
        cable_set="none",
    )
    with pytest.raises(InputError, match="two links would have the name 'a_b_link_1'"):
        combine("b", [Member("a", tricky), Member("a_b", arm)])
    with pytest.raises(InputError, match="no robots"):
        combine("b", [])
    with pytest.raises(InputError, match="different gravity"):
        combine("b", [Member("a", arm), Member("b", replace(arm, gravity=(0.0, 0.0, 0.0)))])
