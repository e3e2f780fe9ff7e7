from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support.recorded import sinusoidal_result, with_columns
from support.robots.loops import four_bar
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import InputError, Pose, WrapSurface, read_robot
from cardsflow_fmu.results.viewer import Motion, Stage, motion_of
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.colours import RAMP, SLACK, tension_colour
from cardsflow_fmu.results.viewer.scene.link_bodies import link_capsules
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses, moved_point
from cardsflow_fmu.results.viewer.scene.motion import MAX_FRAMES, frame_rows
from cardsflow_fmu.results.viewer.scene.muscle_paths import muscle_paths, unit_forces
from cardsflow_fmu.simulation.result import SystemResult
from sim_dart import DartDynamics


def by_name(shapes: list[s.Shape]) -> dict[str, s.Shape]:
    found = {shape.name: shape for shape in shapes}
    assert len(found) == len(shapes)
    return found


@pytest.mark.parametrize("seed", range(5))
def test_link_poses_match_the_dynamics(seed: int) -> None:
    robot = random_robot(seed)
    dynamics = DartDynamics(robot)
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, (7, dynamics.n))
    poses = link_poses(robot, q)
    hand = robot.task_frames[0]
    y = np.array([dynamics.task_position(row)[:3] for row in q])
    np.testing.assert_allclose(moved_point(poses[hand.link], hand.position), y, atol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_drawn_muscles_have_the_simulated_lengths(seed: int) -> None:
    robot = random_robot(seed)
    dynamics = DartDynamics(robot)
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, (7, dynamics.n))
    steps = [np.diff(p.points, axis=1) for p in muscle_paths(robot, q, link_poses(robot, q))]
    drawn = np.stack([np.linalg.norm(step, axis=2).sum(axis=1) for step in steps], axis=1)
    np.testing.assert_allclose(drawn, [dynamics.muscle_lengths(row) for row in q], atol=1e-12)


def test_muscles_are_drawn_over_their_wrap_surfaces() -> None:
    """With the simulated length, except for chords of arcs; through all via points and outside."""
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    dynamics = DartDynamics(robot)
    lower, upper = dynamics.q_min, dynamics.q_max
    q = lower + np.random.default_rng(0).uniform(size=(20, dynamics.n)) * (upper - lower)
    poses = link_poses(robot, q)
    longer = 0
    for k, path in enumerate(muscle_paths(robot, q, poses)):
        drawn = np.linalg.norm(np.diff(path.points, axis=1), axis=2).sum(axis=1)
        true = np.array([dynamics.muscle_lengths(row)[k] for row in q])
        assert ((drawn <= true + 1e-12) & (drawn >= true * (1 - 2e-3))).all()
        longer += path.points.shape[1] > path.via.shape[1]
        for i, point in enumerate(robot.muscles[k].via_points):
            corner = path.points[np.arange(len(q)), path.via[:, i]]
            np.testing.assert_allclose(corner, moved_point(poses[point.link], point.position))
    assert longer


def test_force_arrows_satisfy_virtual_work() -> None:
    """The virtual work of the forces at the via points equals -dl/dq."""
    robot = random_robot(3)
    dynamics = DartDynamics(robot)
    q, h = np.random.default_rng(3).uniform(-1.0, 1.0, dynamics.n), 1e-6
    L = dynamics.muscle_jacobian(q)
    for k in range(dynamics.n):
        moved = q + h * np.eye(dynamics.n)[k] * np.array([[-1.0], [0.0], [1.0]])
        for i, path in enumerate(muscle_paths(robot, moved, link_poses(robot, moved))):
            speed = (path.points[2] - path.points[0]) / (2 * h)
            assert np.sum(unit_forces(path)[1] * speed) == pytest.approx(-L[i, k], abs=1e-7)


def test_planar_arm_is_drawn_at_the_closed_form_position() -> None:
    a, b = 0.4, -0.9
    stage = Stage(planar_2r(), Motion.still([a, b]))
    shapes = by_name(stage.scene(0))
    elbow = np.array([math.sin(a), 0.0, math.cos(a)])
    tip = elbow + np.array([math.sin(a + b), 0.0, math.cos(a + b)])
    np.testing.assert_allclose(shapes["links/link_1/0"].points, [np.zeros(3), elbow], atol=1e-15)
    np.testing.assert_allclose(shapes["links/link_2/0"].points, [elbow, tip], atol=1e-15)
    np.testing.assert_allclose(shapes["links/joint joint_2"].points, [elbow], atol=1e-15)
    frame = shapes["joint frames/joint_2"]
    assert isinstance(frame, s.Frame)
    z = (frame.points[3] - frame.points[0]) / frame.length
    np.testing.assert_allclose(z, tip - elbow, atol=1e-12)
    label = shapes["joint values/joint_2"]
    assert isinstance(label, s.Label)
    assert label.text == "joint_2: -0.900"
    assert (label.position - elbow) @ [0.0, 0.0, 1.0] > 0.0


def test_scene_has_all_groups_of_shapes() -> None:
    robot = read_robot(EXAMPLES / "roboy_left_arm/robot")
    result = sinusoidal_result(robot)
    hand = {f"y_d.hand.{axis}": np.full(len(result.rows), 0.1) for axis in "xyz"}
    stage = Stage(robot, motion_of(robot, with_columns(result, hand)))
    shapes = stage.scene(len(stage) // 2)
    groups = {shape.group for shape in shapes}
    assert groups == set(s.GROUPS) - {s.WRAP_SURFACES, s.CONTACTS, s.OBJECTS, s.GROUND}
    assert sum(shape.group == s.MUSCLES for shape in shapes) == 11
    assert all(np.isfinite(shape.points).all() for shape in shapes)


def test_all_frames_have_the_same_shapes_and_trails_grow() -> None:
    robot = planar_2r()
    stage = Stage(robot, motion_of(robot, sinusoidal_result(robot)))
    frames = [by_name(stage.scene(k)) for k in range(len(stage))]
    assert all(list(frame) == list(frames[0]) for frame in frames)
    trails = [frame["trail/tip"].points for frame in frames]
    for before, after in pairwise(trails):
        np.testing.assert_array_equal(before, after[: len(before)])
    assert len(trails[-1]) > len(trails[0]) == 1
    tip = frames[-1]["links/link_2/0"].points[1]
    apart = np.linalg.norm(np.diff(trails[-1], axis=0), axis=1)
    step = 3.0 * 0.0045 * stage.reach  # along the path; a chord is shorter
    assert apart.max() <= step * (1.0 + 1e-9)
    assert np.median(apart) == pytest.approx(step, rel=0.01)
    assert np.linalg.norm(trails[-1][-1] - tip) < step


def test_joint_reference_is_drawn_as_path_of_the_hand() -> None:
    robot = planar_2r()
    result = sinusoidal_result(robot)
    followed = {f"q_d.joint_{k}": result[f"q.joint_{k}"] + 0.1 for k in (1, 2)}
    motion = motion_of(robot, with_columns(result, followed))
    a, b = motion.q.T + 0.1
    way = Stage(robot, motion).reference["tip"]
    expected = np.stack([np.sin(a) + np.sin(a + b), 0 * a, np.cos(a) + np.cos(a + b)], axis=1)
    np.testing.assert_allclose(way, expected, atol=1e-12)


def test_axes_without_reference_use_the_actual_path() -> None:
    robot = planar_2r()  # its task coordinates are x and z
    result = sinusoidal_result(robot)
    followed = {"y_d.tip.x": np.ones(len(result.rows)), "y_d.tip.z": np.zeros(len(result.rows))}
    stage = Stage(robot, motion_of(robot, with_columns(result, followed)))
    expected = np.tile([1.0, 0.0, 0.0], (len(stage), 1))
    np.testing.assert_allclose(stage.reference["tip"], expected, atol=1e-12)


def test_colours_range_from_f_min_to_f_max_or_the_maximum_tension() -> None:
    robot = planar_2r()  # 10 to 100 N
    tensions = np.array([[10.0, 100.0, 55.0, 10.0]])
    motion = replace(Motion.still([0.1, 0.2]), tensions=tensions)
    shapes = by_name(Stage(robot, motion, full_scale=True).scene(0))
    assert shapes["muscles/cable_1"].colour == RAMP[0]
    assert shapes["muscles/cable_2"].colour == RAMP[-1]
    assert shapes["muscles/cable_3"].colour == RAMP[2]
    weaker = Stage(robot, replace(motion, tensions=tensions / 2))
    assert weaker.tension_range(0) == (10.0, 50.0)
    assert by_name(weaker.scene(0))["muscles/cable_2"].colour == RAMP[-1]
    assert tension_colour(math.nan, 0.0, 1.0) == SLACK


def test_length_of_a_force_arrow_is_proportional_to_the_tension() -> None:
    robot = planar_2r()
    tensions = np.array([[10.0, 40.0, 20.0, 0.0]])
    shapes = by_name(Stage(robot, replace(Motion.still([0.1, 0.2]), tensions=tensions)).scene(0))
    arrows = [shapes[f"forces/cable_{k}/0"].points for k in (1, 2, 3, 4)]
    lengths = [np.linalg.norm(end - start) for start, end in arrows]
    np.testing.assert_allclose(np.array(lengths) / lengths[1], tensions[0] / 40.0, atol=1e-12)
    line = shapes["muscles/cable_2"].points
    toward = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    np.testing.assert_allclose(arrows[1][1] - arrows[1][0], lengths[1] * toward, atol=1e-12)


def test_recorded_contact_forces_are_drawn() -> None:
    robot = planar_2r()
    result = sinusoidal_result(robot)
    forces = {
        f"contact.link_2.f{a}": np.full(len(result.rows), v)
        for a, v in zip("xyz", (0, 0, 9), strict=True)
    }
    stage = Stage(robot, motion_of(robot, with_columns(result, forces)))
    arrow = by_name(stage.scene(3))["contacts/link_2"]
    assert isinstance(arrow, s.Arrow)
    direction = (arrow.end - arrow.start) / np.linalg.norm(arrow.end - arrow.start)
    np.testing.assert_allclose(direction, [0.0, 0.0, 1.0], atol=1e-12)


def test_wrap_surfaces_move_with_their_link() -> None:
    turned = Pose((0.0, 0.0, 0.5), (math.pi / 2, 0.0, 0.0))  # its axis along -y of the link
    surfaces = (
        WrapSurface("ball", "link_2", "sphere", 0.1, Pose((0.0, 0.0, 1.0))),
        WrapSurface("pulley", "link_1", "cylinder", 0.1, turned, 0.3),
        WrapSurface("endless", "world", "cylinder", 0.1),
    )
    robot = replace(planar_2r(), wrap_surfaces=surfaces)
    shapes = by_name(Stage(robot, Motion.still([math.pi / 2, 0.0])).scene(0))
    np.testing.assert_allclose(shapes["wrap surfaces/ball"].points, [[2.0, 0.0, 0.0]], atol=1e-12)
    ends = shapes["wrap surfaces/pulley"].points
    np.testing.assert_allclose(ends, [[0.5, 0.15, 0.0], [0.5, -0.15, 0.0]], atol=1e-12)
    assert np.isfinite(shapes["wrap surfaces/endless"].points).all()
    assert shapes["wrap surfaces/ball"].opacity < 1.0


def test_frames_have_a_constant_rate_and_end_with_the_run() -> None:
    time = np.arange(1001) * 1e-3
    rows = frame_rows(time, 25.0)
    assert rows[0] == 0
    assert rows[-1] == 1000
    assert set(np.diff(rows)) == {40}
    slow = frame_rows(np.arange(11) * 0.1, 25.0)
    np.testing.assert_array_equal(slow, np.arange(11))
    np.testing.assert_array_equal(frame_rows(np.array([0.0])), [0])


@pytest.mark.parametrize("duration", [3600.0, 1e300])
def test_long_run_has_a_lower_frame_rate(duration: float) -> None:
    rows = frame_rows(np.linspace(0.0, duration, 100_001))
    assert len(rows) == MAX_FRAMES + 1
    assert set(np.diff(rows)) == {4}


def test_results_that_cannot_be_drawn_are_rejected() -> None:
    robot = planar_2r()
    result = sinusoidal_result(robot)
    nothing = SystemResult(result.names, result.rows[:0], {}, {})
    with pytest.raises(InputError, match="has no rows"):
        motion_of(robot, nothing)
    lacking = SystemResult(("time", "q.joint_1"), result.rows[:, :2], {}, {})
    with pytest.raises(InputError, match=r"no column 'q\.joint_2'"):
        motion_of(robot, lacking)


def test_diverged_state_is_drawn() -> None:
    robot = planar_2r()
    result = sinusoidal_result(robot)
    result.rows[-1, 1:] = np.nan
    stage = Stage(robot, motion_of(robot, result))
    assert np.isfinite(stage.reach)
    assert len(stage.scene(len(stage) - 1)) == len(stage.scene(0))


def test_colours_differ_and_get_lighter_for_every_kind_of_colour_vision() -> None:
    """Simulate missing cones with the matrices of Machado et al. (2009), in linear RGB."""
    lightness = np.array([0.2126, 0.7152, 0.0722])
    srgb = np.array(RAMP) / 255.0
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    protan = [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]]
    deutan = [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]]
    tritan = [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]]
    for seen in (np.eye(3), protan, deutan, tritan):
        luminance = np.clip(linear @ np.array(seen).T, 0.0, 1.0) @ lightness
        assert (np.diff(np.cbrt(luminance)) > 0.03).all()


def test_link_capsules_reach_the_joints_that_close_loops() -> None:
    robot = four_bar()
    rocker = next(link for link in robot.links if link.name == "rocker_bar")
    ((begin, end),) = link_capsules(robot, rocker)
    assert (begin.tolist(), end.tolist()) == ([0.0, 0.0, 0.0], [0.4, 0.0, 0.0])


def test_link_capsules_begin_at_the_joint_that_moves_the_link() -> None:
    robot = four_bar()
    moved = Pose((0.1, 0.2, 0.0))
    joints = [replace(j, T_child_joint=moved) for j in robot.joints]
    link = next(one for one in robot.links if one.name == robot.joints[0].child)
    capsules = list(link_capsules(replace(robot, joints=tuple(joints)), link))
    assert capsules
    assert all(begin.tolist() == [0.1, 0.2, 0.0] for begin, _ in capsules)
