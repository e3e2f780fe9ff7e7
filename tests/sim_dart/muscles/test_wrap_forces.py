"""Forces of wrapped muscles: power, Newton's third law, and drawn lines."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.path_checks import total_forces
from support.robots.random_robots import random_robot
from support.robots.robots import chain, planar_2r
from support.robots.wrapped import base_pulley, sequences, single_wraps, wrapped_tree

from addin_sdfusion.robot import WORLD, Robot, WrapSurface
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray
from sim_dart.core.frames import moving_frames

pytestmark = pytest.mark.native
TREES = [wrapped_tree(random_robot(seed), seed) for seed in range(12)]
ROBOTS = [planar_2r(), chain(), *TREES]


def velocities(
    robot: Robot, q: FloatArray, qd: FloatArray
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return the angular velocity of each link and the velocity at the world origin."""
    frames, places = moving_frames(robot)
    R, p, w, v = [], [], [], []
    for frame in frames:
        up = frame.parent
        R_up, p_up = (R[up], p[up]) if up >= 0 else (np.eye(3), np.zeros(3))
        w_up, v_up = (w[up], v[up]) if up >= 0 else (np.zeros(3), np.zeros(3))
        R_0 = R_up @ frame.T_parent_frame[:3, :3]
        origin = p_up + R_up @ frame.T_parent_frame[:3, 3]
        axis = np.array(frame.motion.axis) / np.linalg.norm(frame.motion.axis)
        z, angle, rate = R_0 @ axis, q[frame.coordinate], qd[frame.coordinate]
        if frame.motion.kind == "translation":
            R.append(R_0)
            p.append(origin + angle * z)
            w.append(w_up)
            v.append(v_up + rate * z)
            continue
        K = np.cross(np.eye(3), axis)
        R.append(R_0 @ (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K))
        p.append(origin)
        w.append(w_up + rate * z)
        v.append(v_up - rate * np.cross(z, origin))
    still = (np.zeros(3), np.zeros(3))
    return {
        name: (w[place.frame], v[place.frame]) if place.frame >= 0 else still
        for name, place in places.items()
    }


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_power_of_point_forces_equals_power_of_tensions(robot: Robot) -> None:
    """The sum of forces times velocities equals -f . l' to 1e-12."""
    rng = np.random.default_rng(1)
    paths, n, m = MusclePaths(robot), len(robot.coordinates), len(robot.muscles)
    for _ in range(20):
        q, qd, f = rng.uniform(-1.5, 1.5, n), rng.normal(size=n), rng.uniform(0, 1, m)
        pulls = paths.point_forces(q, f)
        rates = paths.evaluate(q).jacobian @ qd
        moving = velocities(robot, q, qd)
        power = np.zeros(m)
        for k, link, point, force in zip(*pulls, strict=True):
            w, v = moving[link]
            power[k] += force @ (v + np.cross(w, point))
        np.testing.assert_allclose(power, -f * rates, rtol=0, atol=1e-12)


@pytest.mark.parametrize("robot", TREES, ids=lambda robot: robot.name)
def test_action_is_reaction(robot: Robot) -> None:
    """The sums of forces and torques of a muscle are zero."""
    rng = np.random.default_rng(2)
    paths, m = MusclePaths(robot), len(robot.muscles)
    for _ in range(20):
        pulls = paths.point_forces(rng.uniform(-1.5, 1.5, len(robot.coordinates)), np.ones(m))
        force, torque = total_forces(pulls, m)
        assert abs(force).max() < 1e-12
        assert abs(torque).max() < 1e-12


def test_inner_via_points_have_the_forces_of_both_segments() -> None:
    """The published plug-in ignores one of the segments."""
    robot = chain()
    f = np.random.default_rng(3).uniform(1, 2, len(robot.muscles))
    q = np.random.default_rng(4).uniform(-0.5, 0.5, 20)
    paths = MusclePaths(robot)
    pulls, lines = paths.point_forces(q, f), paths.path_points(q)
    for k, line in enumerate(lines):
        for i in range(1, len(line) - 1):
            here = (pulls.muscles == k) & (abs(pulls.points - line[i]).max(axis=1) < 1e-12)
            units = [
                (p - line[i]) / np.linalg.norm(p - line[i]) for p in (line[i - 1], line[i + 1])
            ]
            assert here.sum() == 2
            np.testing.assert_allclose(
                pulls.forces[here].sum(axis=0), f[k] * sum(units), atol=1e-12
            )


@pytest.mark.parametrize(
    "robot",
    [
        single_wraps(np.random.default_rng(5), 50, sides=(0, 1, -1), turns=(0, 2)),
        sequences(np.random.default_rng(6), 30, 3, pulley=True),
    ],
    ids=["single", "sequences"],
)
def test_drawn_lines_have_the_lengths_of_the_paths(robot: Robot) -> None:
    """Arcs are polygons with steps of 5 degrees, which are shorter by at most 3e-4."""
    paths = MusclePaths(robot)
    q = np.array([0.05, -0.02, 0.03])
    lengths, lines = paths.evaluate(q).lengths.copy(), paths.path_points(q)
    for muscle, length, line in zip(robot.muscles, lengths, lines, strict=True):
        drawn = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert length * (1 - 4e-4) <= drawn <= length + 1e-9
        np.testing.assert_allclose(line[0], muscle.via_points[0].position)
        np.testing.assert_allclose(line[-1], np.array(muscle.via_points[1].position) + q)


def test_drawn_lines_do_not_penetrate_surfaces() -> None:
    robot = single_wraps(np.random.default_rng(7), 100)
    paths = MusclePaths(robot)
    for surface, line in zip(robot.wrap_surfaces, paths.path_points(np.zeros(3)), strict=True):
        if surface.shape == "sphere" and min(_distances(line[[0, -1]], surface)) > surface.radius:
            assert min(_distances(line, surface)) >= surface.radius * (1 - 1e-9)


def _distances(points: FloatArray, surface: WrapSurface) -> FloatArray:
    centre = surface.pose.position
    distances: FloatArray = np.linalg.norm(points - centre, axis=1)
    return distances


def test_pulley_has_the_force_of_the_outgoing_cable() -> None:
    robot = sequences(np.random.default_rng(8), 1, 1, pulley=True)
    muscle = robot.muscles[0]
    robot = robot.with_muscles(
        [type(muscle)("m", muscle.via_points, pulley=base_pulley(0.05, (0, 0, 1)))]
    )
    pulls = MusclePaths(robot).point_forces(np.zeros(3), [2.0])
    assert pulls.links == (WORLD, "link_2")
    np.testing.assert_allclose(pulls.forces[0], -pulls.forces[1])
    assert np.linalg.norm(pulls.forces[0]) == pytest.approx(2.0)
