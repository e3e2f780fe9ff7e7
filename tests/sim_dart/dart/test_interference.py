"""Distances between muscles, and between muscles and links."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from support.robots.random_robots import random_robot
from support.robots.worlds import two_link_arm, write_box_mesh

from addin_sdfusion.robot import (
    WORLD,
    CableSet,
    CoordinateTerm,
    Link,
    Mesh,
    Muscle,
    Pose,
    Robot,
    Shape,
    ViaPoint,
)
from sim_dart.dart.interference import Interference, _pairs_within, segment_distances
from sim_dart.scene import Scene


def optimized_distance(p, p_end, r, r_end) -> float:
    """Return the distance of two segments from a general optimizer."""

    def square(x):
        gap = p + x[0] * (p_end - p) - r - x[1] * (r_end - r)
        return gap @ gap

    tries = [minimize(square, x, bounds=[(0, 1)] * 2, tol=1e-14).fun for x in ([0, 0], [1, 1])]
    return float(np.sqrt(max(min(tries), 0.0)))


@pytest.mark.slow
def test_segment_distances_equal_an_optimizer() -> None:
    rng = np.random.default_rng(1)
    p, p_end, r, r_end = rng.uniform(-1, 1, (4, 50, 3))
    distances = segment_distances(p, p_end, r, r_end)
    expected = [optimized_distance(*ends) for ends in zip(p, p_end, r, r_end, strict=True)]
    np.testing.assert_allclose(distances, expected, atol=1e-5)


CASES = {
    "crossing": ([-1, 0, 0], [1, 0, 0], [0, -1, 0.5], [0, 1, 0.5], 0.5),
    "meeting": ([-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], 0.0),
    "parallel": ([0, 0, 0], [1, 0, 0], [0.5, 2, 0], [3, 2, 0], 2.0),
    "in a row": ([0, 0, 0], [1, 0, 0], [3, 0, 0], [4, 0, 0], 2.0),
    "overlapping": ([0, 0, 0], [2, 0, 0], [1, 0, 0], [4, 0, 0], 0.0),
    "end to middle": ([0, 0, 0], [1, 0, 0], [0.3, 1, 0], [0.3, 5, 0], 1.0),
    "point": ([0, 0, 0], [0, 0, 0], [-1, 1, 0], [1, 1, 0], 1.0),
    "points": ([0, 0, 0], [0, 0, 0], [3, 4, 0], [3, 4, 0], 5.0),
}


@pytest.mark.parametrize("case", CASES)
def test_segment_distances_in_degenerate_cases(case: str) -> None:
    *ends, expected = CASES[case]
    arrays = [np.array([end], float) for end in ends]
    assert segment_distances(*arrays)[0] == pytest.approx(expected, abs=1e-15)
    swapped = [arrays[2], arrays[3], arrays[1], arrays[0]]
    assert segment_distances(*swapped)[0] == pytest.approx(expected, abs=1e-15)


@given(st.integers(0, 10_000))
def test_segment_distance_is_at_most_that_of_any_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    p, p_end, r, r_end = rng.uniform(-1, 1, (4, 1, 3)) * rng.choice([1e-6, 1.0, 1e3])
    if seed % 4 == 0:
        r_end = r + (p_end - p) * rng.choice([1.0, 3.0, -0.1])  # parallel, but for rounding
    s, t = rng.uniform(0, 1, (2, 50, 1))
    between = np.linalg.norm(p + s * (p_end - p) - r - t * (r_end - r), axis=1).min()
    assert segment_distances(p, p_end, r, r_end)[0] <= between * (1 + 1e-9) + 1e-15


def crossing_muscles() -> Robot:
    """Return an arm with a muscle, and a second muscle that the arm crosses when it swings."""
    arm = two_link_arm()
    swinging = Muscle("swinging", (ViaPoint("link_1", (0, 0, 0)), ViaPoint("link_2", (0, 0, -0.3))))
    standing = Muscle("standing", (ViaPoint(WORLD, (0.4, -1, 0.3)), ViaPoint(WORLD, (0.4, 1, 0.3))))
    return replace(arm, cable_sets=(CableSet("all", (swinging, standing)),))


def test_muscle_distance_equals_closed_form() -> None:
    """The end of the straight arm at the angle a is (-0.6 sin a, 0.7 - 0.6 cos a)."""
    angles = np.linspace(0.0, -1.2, 241)
    postures = [np.array([a, 0.0]) for a in angles]
    (near,) = Interference(crossing_muscles(), Scene(links="none")).nearest(postures)
    assert (near.muscle, near.other, near.is_link) == ("swinging", "standing", False)
    assert near.distance < 1e-3
    assert np.tan(-angles[near.sample]) == pytest.approx(0.4 / 0.4, abs=0.02)


def test_smallest_distance_of_all_postures_is_reported() -> None:
    check = Interference(crossing_muscles(), Scene(links="none"))
    far, close = np.array([0.0, 0.0]), np.array([-0.7, 0.0])
    (alone,) = check.nearest([close])
    (both,) = check.nearest([far, close, far])
    assert both.distance == alone.distance
    assert both.sample == 1


def test_muscles_with_a_common_attachment_do_not_collide_there() -> None:
    arm = two_link_arm()
    hook = ViaPoint(WORLD, (0.2, 0.0, 0.7))
    pair = tuple(
        Muscle(name, (hook, ViaPoint("link_2", (x, y, -0.1))))
        for name, x, y in (("a", 0.03, 0.0), ("b", 0.0, 0.05))
    )
    robot = replace(arm, cable_sets=(CableSet("all", pair),))
    assert Interference(robot, Scene(links="none")).nearest([np.zeros(2)]) == []


def test_muscle_without_path_is_skipped() -> None:
    robot = crossing_muscles()
    terms = (CoordinateTerm(two_link_arm().coordinates[0].name, 0.05),)
    fixed = Muscle("fixed", (), terms=terms)
    more = replace(robot, cable_sets=(CableSet("all", (fixed, *robot.muscles)),))
    for scene in (Scene(links="none"), Scene(links="capsules", capsule_radius=0.03)):
        near = Interference(robot, scene).nearest([np.array([-0.7, 0.0])])
        assert Interference(more, scene).nearest([np.array([-0.7, 0.0])]) == near


def test_distance_to_capsule_is_distance_to_axis_minus_radius() -> None:
    arm = two_link_arm()
    passing = Muscle("m", (ViaPoint(WORLD, (0.25, -1, 0.2)), ViaPoint(WORLD, (0.25, 1, 0.2))))
    robot = replace(arm, cable_sets=(CableSet("all", (passing,)),))
    check = Interference(robot, Scene(links="capsules", capsule_radius=0.03))
    near = {n.other: n for n in check.nearest([np.zeros(2)])}
    assert near["link_2"].distance == pytest.approx(0.25 - 0.03)
    assert near["link_2"].is_link
    assert near["link_1"].distance == pytest.approx(np.hypot(0.25, 0.2) - 0.03)


@pytest.mark.parametrize(("x", "expected"), [(0.2, 0.15), (0.05, 0.0), (0.02, -0.03), (0.0, -0.05)])
def test_depth_in_hull_is_distance_to_nearest_face(
    x: float, expected: float, tmp_path: Path
) -> None:
    """The cube of 0.1 m is at the middle of link 2, 0.25 m below the elbow."""
    write_box_mesh(tmp_path)
    name = next(tmp_path.iterdir()).name
    arm = two_link_arm()
    mesh = Mesh("collision", name, Pose((0.0, 0.0, -0.15)))
    links = (arm.links[0], Link("link_2", arm.links[1].inertia, meshes=(mesh,)))
    passing = Muscle("m", (ViaPoint(WORLD, (x, -1, 0.25)), ViaPoint(WORLD, (x, 1, 0.25))))
    robot = replace(arm, links=links, cable_sets=(CableSet("all", (passing,)),))
    check = Interference(robot, Scene(mesh_folder=tmp_path))
    (near,) = check.nearest([np.zeros(2)])
    assert near.other == "link_2"
    assert near.distance == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        (Shape("box", (0.1, 0.1, 0.1)), 0.15),
        (Shape("sphere", (0.08,)), 0.12),
        (Shape("cylinder", (0.07, 0.3)), 0.13),
        (Shape("cylinder", (0.07, 0.3), Pose(rpy=(0.0, np.pi / 2, 0.0))), 0.05),
    ],
)
def test_collision_shapes_of_links_are_used(shape: Shape, expected: float) -> None:
    arm = two_link_arm()
    own = replace(shape, pose=Pose((0.0, 0.0, -0.15), shape.pose.rpy))
    links = (arm.links[0], Link("link_2", arm.links[1].inertia, shapes=(own,)))
    passing = Muscle("m", (ViaPoint(WORLD, (0.2, -1, 0.25)), ViaPoint(WORLD, (0.2, 1, 0.25))))
    robot = replace(arm, links=links, cable_sets=(CableSet("all", (passing,)),))
    (near,) = Interference(robot, Scene()).nearest([np.zeros(2)])
    assert near.other == "link_2"
    assert near.distance == pytest.approx(expected, abs=1e-7)


def test_search_within_a_distance_omits_far_links() -> None:
    """The muscles are 0.05 m and 0.15 m from a box."""
    arm, shape = two_link_arm(), Shape("box", (0.1, 0.1, 0.1), Pose((0.0, 0.0, -0.15)))
    links = (arm.links[0], Link("link_2", arm.links[1].inertia, shapes=(shape,)))
    muscles = tuple(
        Muscle(f"m{x:g}", (ViaPoint(WORLD, (x, -1, 0.25)), ViaPoint(WORLD, (x, 1, 0.25))))
        for x in (0.1, 0.2)
    )
    check = Interference(replace(arm, links=links, cable_sets=(CableSet("all", muscles),)), Scene())
    every = [near for near in check.nearest([np.zeros(2)]) if near.is_link]
    assert [near.distance for near in every] == pytest.approx([0.05, 0.15], abs=1e-7)
    close = check.nearest([np.zeros(2)], within=0.1)
    assert [near for near in close if near.is_link] == every[:1]


def test_links_with_via_points_of_the_muscle_are_skipped() -> None:
    check = Interference(two_link_arm(), Scene(links="capsules", capsule_radius=0.5))
    assert [near.other for near in check.nearest([np.zeros(2)])] == ["link_1"]


def test_every_pair_of_a_random_robot_is_reported_once() -> None:
    robot = random_robot(3)
    postures = np.random.default_rng(0).uniform(-1, 1, (5, len(robot.coordinates)))
    found = Interference(robot, Scene(links="none")).nearest(postures)
    pairs = {frozenset((n.muscle, n.other)) for n in found}
    m = len(robot.muscles)
    assert len(found) == len(pairs) == m * (m - 1) // 2
    distances = [n.distance for n in found]
    assert distances == sorted(distances)


@pytest.mark.parametrize("within", [0.0, 0.05, 0.3])
def test_search_within_a_distance_finds_the_same_pairs(within: float) -> None:
    robot = random_robot(3)
    postures = np.random.default_rng(0).uniform(-1, 1, (5, len(robot.coordinates)))
    check = Interference(robot, Scene(links="none"))
    every, near = check.nearest(postures), check.nearest(postures, within)
    assert [n for n in every if n.distance <= within] == [n for n in near if n.distance <= within]


@pytest.mark.parametrize("within", [0.0, 0.05, 0.3])
def test_near_pairs_of_segments_are_not_omitted(within: float) -> None:
    rng = np.random.default_rng(1)
    starts = rng.uniform(-1, 1, (80, 3))
    ends = starts + rng.uniform(-0.3, 0.3, starts.shape)
    i, j = np.triu_indices(len(starts), 1)
    near = segment_distances(starts[i], ends[i], starts[j], ends[j]) <= within
    found = set(zip(*_pairs_within(starts, ends, within), strict=True))
    assert set(zip(i[near], j[near], strict=True)) <= found
    assert len(found) < len(i) / 2
