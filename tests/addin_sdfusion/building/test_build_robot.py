"""Tests of robots built from designs, compared with robots written by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.designs.design_strategies import (
    KINDS,
    Draughtsman,
    Drawn,
    drawn_designs,
    forward,
    initial,
    matrix,
    motion_matrix,
    shuffled,
)

from addin_sdfusion.building.build_robot import BuiltRobot, build_robot, check_design, link_of
from addin_sdfusion.robot import Robot
from addin_sdfusion.snapshot import DesignSnapshot
from sim_dart import DartDynamics


def built(snapshot: DesignSnapshot) -> tuple[BuiltRobot, Robot]:
    made = build_robot(snapshot)
    assert [f for f in made.findings if f.is_error] == []
    assert made.robot is not None
    return made, made.robot


def in_order_of(robot: Robot, q: dict[str, float]) -> Any:
    return np.array([q[c.name] for c in robot.coordinates])


@pytest.mark.slow
@given(drawn_designs(), st.integers(0, 1000))
def test_a_drawn_robot_equals_the_written_one(drawn: Drawn, seed: int) -> None:
    made, robot = built(drawn.snapshot)
    assert build_robot(shuffled(drawn.snapshot, seed)) == made
    written = {c.name: c for c in drawn.robot.coordinates}
    got = {c.name: c for c in robot.coordinates}
    assert got == written
    if not got:
        return
    a, b = DartDynamics(robot), DartDynamics(drawn.robot)
    index = [[c.name for c in drawn.robot.coordinates].index(c.name) for c in robot.coordinates]
    muscles = [b.muscle_names.index(name) for name in a.muscle_names]
    rng = np.random.default_rng(seed)
    for _ in range(2):
        q = dict(zip(got, rng.uniform(-1.0, 1.0, len(got)), strict=True))
        qa, qb = in_order_of(robot, q), in_order_of(drawn.robot, q)
        M = b.mass_matrix(qb)[np.ix_(index, index)]
        np.testing.assert_allclose(a.mass_matrix(qa), M, rtol=1e-9, atol=1e-9)
        L = b.muscle_jacobian(qb)[np.ix_(muscles, index)]
        np.testing.assert_allclose(a.muscle_jacobian(qa), L, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(a.gravity(qa), b.gravity(qb)[index], rtol=1e-9, atol=1e-9)
        lengths = b.muscle_lengths(qb)[muscles]
        np.testing.assert_allclose(a.muscle_lengths(qa), lengths, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(a.task_position(qa), b.task_position(qb), rtol=1e-9, atol=1e-9)


@pytest.mark.slow
@given(drawn_designs())
def test_initial_pose_equals_the_pose_of_the_design(drawn: Drawn) -> None:
    made, robot = built(drawn.snapshot)
    poses = forward(robot, initial(robot))
    for link in robot.links:
        T = poses[link.name]
        np.testing.assert_allclose(matrix(made.T_world_link[link.name]), T, atol=1e-12)
        written = drawn.robot.link(link.name).inertia
        T_drawn = drawn.T_root_link[link.name]
        com = T_drawn @ [*written.com, 1.0]
        np.testing.assert_allclose(T @ [*link.inertia.com, 1.0], com, atol=1e-12)
        R, R_drawn = T[:3, :3], T_drawn[:3, :3]
        J = R @ np.array(link.inertia.matrix) @ R.T
        np.testing.assert_allclose(J, R_drawn @ np.array(written.matrix) @ R_drawn.T, atol=1e-12)
    drawn_at = {(p.name): p.position for p in drawn.snapshot.points}
    assert drawn_at
    for muscle in robot.muscles:
        written_points = drawn.robot.muscle(muscle.name).via_points
        assert [v.link for v in muscle.via_points] == [v.link for v in written_points]
        for via, point in zip(muscle.via_points, written_points, strict=True):
            at = drawn.T_root_link[point.link] @ [*point.position, 1.0]
            np.testing.assert_allclose(poses[via.link] @ [*via.position, 1.0], at, atol=1e-12)


@pytest.mark.slow
@given(drawn_designs())
def test_with_all_coordinates_at_zero_every_frame_is_parallel_to_the_world(drawn: Drawn) -> None:
    _, robot = built(drawn.snapshot)
    poses = forward(robot, {c.name: 0.0 for c in robot.coordinates})
    for joint in robot.joints:
        assert not any(joint.T_parent_joint.rpy)
        assert joint.T_child_joint == type(joint.T_child_joint)()
        np.testing.assert_allclose(poses[joint.child][:3, :3], np.eye(3), atol=1e-12)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "rigid"])
@pytest.mark.parametrize("seed", range(4))
def test_a_coordinate_moves_the_child_about_the_axis_of_the_design(kind: str, seed: int) -> None:
    """Compare with rotation matrices about the axes of the snapshot."""
    drawn = Draughtsman(seed, 3, [kind], nesting=1).draw()
    _, robot = built(drawn.snapshot)
    q0 = initial(robot)
    before = forward(robot, q0)
    step = 0.3
    for joint in drawn.snapshot.joints:
        names = {path.rpartition("+")[2][:-2]: path for path in (joint.one, joint.two) if path}
        one = next(n for n, path in names.items() if path == joint.one)
        two = next(n for n, path in names.items() if path == joint.two)
        for k, motion in enumerate(joint.motions):
            name = f"{joint.name}_{motion.role}" if motion.role else joint.name
            after = forward(robot, {**q0, name: q0[name] + step})

            # The frame on `two` has the axes of the snapshot; m1 m2 m3 is the pose of `one` in it.
            def chain(values: list[float], joint: Any = joint) -> Any:
                T = np.eye(4)
                for m, value in zip(joint.motions, values, strict=True):
                    T = T @ motion_matrix(m.kind, m.axis, value)
                return T

            values = [m.value for m in joint.motions]
            moved = [v + step if i == k else v for i, v in enumerate(values)]
            about = np.eye(4)
            about[:3, 3] = joint.origin_two
            change = about @ chain(moved) @ np.linalg.inv(chain(values)) @ np.linalg.inv(about)
            relative = np.linalg.inv(after[two]) @ after[one]
            expected = np.linalg.inv(before[two]) @ change @ before[one]
            np.testing.assert_allclose(relative, expected, atol=1e-12)


@pytest.mark.parametrize("groups", [True, False])
def test_a_design_with_y_up_is_the_same_robot_as_one_with_z_up(groups: bool) -> None:
    """The second design is rotated by -90°, so that y is up."""
    drawn = Draughtsman(3, 4, groups=groups, rotated=True).draw()
    R = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])

    def turn(v: Any) -> Any:
        return None if v is None else tuple(map(float, R @ np.array(v)))

    def turned_mass(mass: Any) -> Any:
        xx, yy, zz, xy, yz, xz = mass.moments
        J = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
        moments = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[1, 2], J[0, 2])
        return replace(mass, com=turn(mass.com), moments=tuple(map(float, moments)))

    s = drawn.snapshot
    lying = replace(
        s,
        settings=replace(s.settings, up_axis="y"),
        occurrences=tuple(
            replace(o, mass=turned_mass(o.mass) if o.mass else None) for o in s.occurrences
        ),
        bodies=tuple(replace(b, mass=turned_mass(b.mass)) for b in s.bodies),
        points=tuple(replace(p, position=turn(p.position)) for p in s.points),
        joints=tuple(
            replace(
                j,
                origin_one=turn(j.origin_one),
                origin_two=turn(j.origin_two),
                motions=tuple(replace(m, axis=turn(m.axis)) for m in j.motions),
            )
            for j in s.joints
        ),
    )
    _, robot = built(s)
    _, turned = built(lying)
    assert turned.gravity == robot.gravity == (0.0, 0.0, -9.81)
    a, b = DartDynamics(robot), DartDynamics(turned)
    q = np.linspace(-0.5, 0.5, a.n)
    np.testing.assert_allclose(a.mass_matrix(q), b.mass_matrix(q), atol=1e-12)
    np.testing.assert_allclose(a.gravity(q), b.gravity(q), atol=1e-12)
    np.testing.assert_allclose(a.muscle_jacobian(q), b.muscle_jacobian(q), atol=1e-12)


def test_a_floating_base_moves_by_six_coordinates() -> None:
    drawn = Draughtsman(5, 3).draw()
    floating = replace(drawn.snapshot.settings, fixed_base=False)
    _, robot = built(replace(drawn.snapshot, settings=floating))
    first = robot.joints[0]
    assert first.type == "free"
    assert [c.name for c in first.coordinates] == [
        f"world_link_0_{word}" for word in ("x", "y", "z", "alpha", "beta", "gamma")
    ]
    _, fixed = built(drawn.snapshot)
    assert robot.joints[1:] == fixed.joints[1:]


def test_links_of_occurrences_are_reported_without_bodies_and_masses() -> None:
    for groups in (True, False):
        snapshot = Draughtsman(2, 3, groups=groups).draw().snapshot
        bare = replace(
            snapshot,
            bodies=(),
            occurrences=tuple(replace(o, mass=None) for o in snapshot.occurrences),
        )
        assert link_of(bare) == link_of(snapshot) == build_robot(snapshot).link_of_occurrence
        for body in snapshot.bodies:
            assert any(
                link_of(snapshot)[body.occurrence] in part for part in body.occurrence.split("+")
            )


def test_check_returns_the_same_findings() -> None:
    snapshot = Draughtsman(2, 3).draw().snapshot
    assert check_design(snapshot) == list(build_robot(snapshot).findings)
