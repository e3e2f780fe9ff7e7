"""Plant in a world: states, speeds, several robots, and errors."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from support.robots.plants import steps
from support.robots.random_robots import random_robot
from support.robots.robots import planar_2r, with_coordinates
from support.robots.worlds import (
    SHAPES,
    G,
    block,
    let_run,
    shape,
    two_link_arm,
    world_of,
    write_box_mesh,
)

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    InputError,
    Joint,
    Link,
    Pose,
    Robot,
    SimulationError,
    revolute,
)
from addin_sdfusion.robot.model.robot import Inertia
from addin_sdfusion.robot.transforms.combine import Member, combine
from sim_dart import Plant
from sim_dart.scene import (
    Box,
    Capsule,
    Cylinder,
    Ground,
    LinkShape,
    MeshShape,
    Scene,
    SceneObject,
    Sphere,
)

ARM = Scene(links="capsules", capsule_radius=0.03)


def falling_boxes(n: int = 3) -> Scene:
    """Return a scene with boxes that fall onto the ground and onto each other."""
    rng = np.random.default_rng(4)
    boxes = tuple(
        SceneObject(
            f"box_{k}",
            Box((0.1, 0.2, 0.05)),
            Pose((0.05 * k, 0.0, 0.3 + 0.3 * k), tuple(rng.uniform(-1, 1, 3).tolist())),
            0.4,
            (0.1, 0.0, 0.0),
            tuple(rng.uniform(-3, 3, 3).tolist()),
        )
        for k in range(n)
    )
    return Scene(Ground(), boxes, 0.7, 0.2)


def test_empty_scene_does_not_change_the_motion() -> None:
    """Without contacts, plants with and without world are bit-identical."""
    robot = planar_2r()
    plain, placed = Plant(robot, engine="dart"), Plant(robot, scene=Scene())
    rng = np.random.default_rng(0)
    for _ in range(200):
        f = rng.uniform(10.0, 40.0, 4)
        plain.step(f)
        placed.step(f)
    np.testing.assert_array_equal(plain.q, placed.q)
    np.testing.assert_array_equal(plain.qd, placed.qd)


@pytest.mark.parametrize("seed", [1, 5, 8])
def test_several_trees_move_like_one_skeleton(seed: int) -> None:
    robot = random_robot(seed, joints=8)
    plain, apart = Plant(robot), Plant(robot, scene=Scene())
    rng = np.random.default_rng(seed)
    q = rng.uniform(-0.5, 0.5, len(robot.coordinates))
    for plant in (plain, apart):
        plant.reset(q, 0.1 * q)
    for _ in range(50):
        f = rng.uniform(0.0, 2.0, len(robot.muscles))
        plain.step(f)
        apart.step(f)
    np.testing.assert_allclose(apart.q, plain.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(apart.momentum.linear, plain.momentum.linear, atol=1e-9)


def test_free_body_follows_a_parabola() -> None:
    body = SceneObject("b", Sphere(0.1), Pose((1, 2, 3)), 2.0, (1.0, -0.5, 4.0), (0.0, 0.0, 2.0))
    poses = let_run(world_of(Scene(objects=(body,))), 0.5)[:, 0]
    t = 0.5
    expected = [1 + t, 2 - 0.5 * t, 3 + 4 * t - 0.5 * G * t * (t + 1e-3)]
    np.testing.assert_allclose(poses[-1, :3], expected, atol=1e-12)
    np.testing.assert_allclose(poses[-1, 3:], [np.cos(t), 0, 0, np.sin(t)], atol=1e-9)


def test_mesh_rotates_about_its_centre_of_mass(tmp_path: Path) -> None:
    mesh = trimesh.creation.box((0.1, 0.1, 0.1))
    mesh.apply_translation((0.2, 0.0, 0.0))
    (tmp_path / "off.stl").write_bytes(trimesh.exchange.stl.export_stl(mesh))
    spin = (0.0, 0.0, 1.0)
    still = (0.0, -0.2, 0.0)  # of the frame's origin, so that the centre of mass stands still
    body = SceneObject("b", MeshShape(tmp_path / "off.stl"), Pose(), 1.0, still, spin)
    robot = replace(block(), gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot, 1e-3, scene=Scene(objects=(body,)))
    pose = let_run(plant, 1.0)[-1, 0]
    centre = pose[:2] + 0.2 * np.array([np.cos(1.0), np.sin(1.0)])
    np.testing.assert_allclose(centre, [0.2, 0.0], atol=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pyramid", "cone"])
def test_run_continues_bit_identically_from_saved_state(law: str) -> None:
    scene = replace(falling_boxes(), friction_law=law, reported=("box_0",))  # type: ignore[arg-type]
    plant = world_of(scene)
    let_run(plant, 0.3)
    state = plant.get_state()
    first, forces = let_run(plant, 0.2), plant.world.contact_forces()
    plant.set_state(state)
    np.testing.assert_array_equal(let_run(plant, 0.2), first)
    np.testing.assert_array_equal(plant.world.contact_forces(), forces)
    other = world_of(scene)
    other.set_state(state)
    np.testing.assert_array_equal(let_run(other, 0.2), first)
    assert other.time == plant.time == pytest.approx(0.5)


def test_reset_restores_objects() -> None:
    plant = world_of(falling_boxes())
    first = let_run(plant, 0.3)
    plant.reset()
    np.testing.assert_array_equal(let_run(plant, 0.3), first)


def test_state_of_another_world_is_rejected() -> None:
    with pytest.raises(InputError, match="shape"):
        world_of(falling_boxes()).set_state(world_of(falling_boxes(2)).get_state())
    bad = world_of(falling_boxes()).get_state()
    bad[-1] = np.nan
    with pytest.raises(InputError, match="objects must be finite"):
        world_of(falling_boxes()).set_state(bad)


def with_initial_state(robot: Robot, q: list[float]) -> Robot:
    """Return the robot with another initial state."""
    joints = tuple(
        replace(joint, coordinates=(replace(joint.coordinates[0], initial=value),))
        for joint, value in zip(robot.joints, q, strict=True)
    )
    return replace(robot, joints=joints)


@pytest.mark.slow
def test_arm_comes_to_rest_on_the_ground() -> None:
    """The arm is too long to hang freely. Its tip comes to rest on the ground."""
    robot = with_initial_state(two_link_arm(), [1.2, 0.2])
    scene = replace(ARM, ground=Ground(0.2), reported=("link_2", "ground"))
    plant = Plant(robot, scene=scene)
    steps(plant, 6000, [0.0])
    lowest = 0.7 - 0.3 * np.cos(plant.q[0]) - 0.3 * np.cos(plant.q.sum()) - 0.03
    assert lowest == pytest.approx(0.2, abs=1e-4)
    forces = plant.world.contact_forces()
    assert forces[0, 2] > 1.0
    np.testing.assert_allclose(forces[0], -forces[1], atol=1e-12)


def test_links_with_a_joint_to_the_world_do_not_collide_with_the_ground() -> None:
    robot = two_link_arm()
    joints = (replace(robot.joints[0], T_parent_joint=Pose()), robot.joints[1])
    low = with_initial_state(replace(robot, joints=joints), [np.pi, 0.0])  # up, out of the ground
    plant = Plant(low, scene=replace(ARM, ground=Ground(0.02)))
    plant.step([0.0])
    assert plant.world.has_contacts
    with pytest.raises(InputError, match=r"('link_2'|'ground') and ('ground'|'link_2') overlap by"):
        plant.reset([np.pi / 2, 0.0])


def folding_angle(self_collision: bool) -> float:
    """Return how far the third link folds back over a short second link."""
    links = tuple(Link(f"l{k}", Inertia(0.5, ixx=1e-3, iyy=1e-3, izz=1e-3)) for k in range(3))
    names, reach = [WORLD, "l0", "l1"], [0.0, 0.2, 0.05]
    joints = tuple(
        Joint(
            f"j{k}",
            names[k],
            f"l{k}",
            revolute((0.0, 1.0, 0.0)),
            (Coordinate(f"j{k}", initial=0.0 if k == 0 else -np.pi / 2, damping=0.01),),
            Pose((reach[k], 0.0, 0.0)),
        )
        for k in range(3)
    )
    bars = tuple(LinkShape(f"l{k}", Box((0.18, 0.02, 0.02)), Pose((0.1, 0.0, 0.0))) for k in (0, 2))
    robot = Robot("folding", links, joints, gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot, scene=Scene(link_shapes=bars, self_collision=self_collision))
    plant.reset(qd=[0.0, 0.0, -3.0])
    angles = []
    for _ in range(500):
        plant.step([])
        angles.append(plant.q[1] + plant.q[2] + np.pi)
    return -float(np.min(angles))


def test_links_of_one_robot_collide_with_self_collision() -> None:
    touching = np.arcsin(0.03 / 0.19)  # about: the far end of the third meets the first
    assert folding_angle(self_collision=True) == pytest.approx(touching, abs=0.03)
    assert folding_angle(self_collision=False) > 2 * touching


def three_arms(distance: float) -> Robot:
    """Return three adjacent two-link arms as one robot with several trees."""
    links, joints = [], []
    for k in range(3):
        arm = two_link_arm()
        links += [replace(link, name=f"{link.name}_{k}") for link in arm.links]
        for joint in arm.joints:
            parent = WORLD if joint.parent == WORLD else f"{joint.parent}_{k}"
            x, y, z = joint.T_parent_joint.position
            shifted = Pose((x + (k * distance if parent == WORLD else 0.0), y, z))
            (c,) = joint.coordinates
            joints.append(
                replace(
                    joint,
                    name=f"{joint.name}_{k}",
                    parent=parent,
                    child=f"{joint.child}_{k}",
                    coordinates=(replace(c, name=f"{c.name}_{k}"),),
                    T_parent_joint=shifted,
                )
            )
    return Robot("arms", tuple(links), tuple(joints))


@pytest.mark.slow
def test_robots_collide_with_each_other() -> None:
    """A swinging arm transfers momentum to the adjacent arm."""
    robot = three_arms(0.25)
    plant = Plant(robot, scene=replace(ARM, reported=("link_2_0", "link_2_1")))
    q = np.zeros(6)
    q[:2] = [1.2, 0.0]  # the first arm leans away
    plant.reset(q)
    hit = 0.0
    for _ in range(1500):
        plant.step([])
        hit = max(hit, float(np.abs(plant.world.contact_forces()[1]).max()))
    assert hit > 1.0
    assert np.abs(plant.q[2:4]).max() > 0.05


@pytest.mark.slow
def test_twenty_robots_in_a_world_move_like_single_robots() -> None:
    """The robots lie on the ground without contact to each other; results are bit-identical."""
    arm = with_initial_state(two_link_arm(), [1.2, 0.2])
    scene = replace(ARM, ground=Ground(0.2))
    places = [Pose((0.0, 2.0 * k, 0.0)) for k in range(20)]
    members = [Member(f"arm{k}", arm, place) for k, place in enumerate(places)]
    many, alone = Plant(combine("many", members), scene=scene), Plant(arm, scene=scene)
    for _ in range(400):
        many.step(np.full(20, 1.0))
        alone.step([1.0])
    assert len(many.world.contacts()) >= 20
    np.testing.assert_allclose(many.q, np.tile(alone.q, 20), rtol=0, atol=1e-9)


# `SpeedWatch` guarantees that bodies that are not rejected do not tunnel.
WALL = 0.01


def shoot(kind: str, wall: str, speed: float, turn: np.ndarray, folder: Path) -> bool:
    """Return whether a body passes through a wall; raise SimulationError if it is rejected."""
    form, _ = shape(kind, folder)
    walls = {
        "box": (Box((WALL, 1.0, 1.0)), Pose()),
        "mesh": (MeshShape(write_box_mesh(folder, (WALL, 1.0, 1.0))), Pose()),
        "cylinder": (Cylinder(0.5, WALL), Pose(rpy=(0.0, np.pi / 2, 0.0))),
    }
    start = Pose((-0.3 - 0.37 * speed * 1e-3, 0.013, -0.007), tuple(turn.tolist()))
    body = SceneObject("body", form, start, 0.5, (speed, 0.0, 0.0))
    obstacle, placed = walls[wall]
    robot = replace(block(), gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot, scene=Scene(objects=(SceneObject("wall", obstacle, placed), body)))
    poses = let_run(plant, 0.3 / speed + 0.05)
    return bool(poses[:, 0, 0].max() > 0.1)


@pytest.mark.cases(6)
@pytest.mark.slow
@pytest.mark.parametrize("wall", ["mesh", "box", "cylinder"])
@pytest.mark.parametrize("kind", SHAPES)
def test_bodies_do_not_tunnel_below_the_speed_limit(kind: str, wall: str, tmp_path: Path) -> None:
    """Check speeds up to the limit with a step of 1 ms.

    The limit is 33 m/s for a body of 0.1 m and a wall of 1 cm, and 2.5 m/s for a cylinder. A body
    that rebounds with a higher speed is rejected, and did not tunnel either.
    """
    limit = 2.5 if "cylinder" in (kind, wall) else 33.0 * (0.97 if kind == "fine mesh" else 1.0)
    rng = np.random.default_rng(3)
    spun_off = 0
    for k in range(12):
        turn = rng.uniform(-3, 3, 3) if k % 3 else np.zeros(3)
        speed = limit * (0.99 if k % 2 else rng.uniform(0.05, 0.99))
        try:
            assert not shoot(kind, wall, speed, turn, tmp_path)
        except SimulationError:
            spun_off += 1
    assert spun_off <= 6
    with pytest.raises(SimulationError, match=r"'body' could pass through 'wall'"):
        shoot(kind, wall, 1.05 * limit, np.zeros(3), tmp_path)


def test_message_contains_time_bodies_speed_and_step(
    tmp_path: Path,
) -> None:
    with pytest.raises(SimulationError) as caught:
        shoot("box", "box", 50.0, np.zeros(3), tmp_path)
    text = str(caught.value)
    assert text.startswith("at t = 0.004 s 'body' could pass through 'wall'")
    assert "50 m/s" in text
    assert "a plant step of at most 0.00066 s" in text


def test_distant_bodies_have_no_speed_limit() -> None:
    wall = SceneObject("wall", Box((WALL, 1.0, 1.0)))
    body = SceneObject("body", Sphere(0.05), Pose((0.0, 5.0, 0.0)), 0.5, (200.0, 0.0, 0.0))
    poses = let_run(world_of(Scene(objects=(wall, body))), 0.1)
    assert poses[-1, 0, 0] == pytest.approx(20.0)


def test_speed_of_a_spinning_link_tip_is_checked() -> None:
    robot = two_link_arm()
    bar = SceneObject("bar", Box((0.002, 0.5, 0.5)), Pose((0.3, 0.0, 0.3)))
    plant = Plant(robot, scene=replace(ARM, objects=(bar,)))
    plant.reset([0.5, 0.0], [-60.0, 0.0])
    with pytest.raises(SimulationError, match=r"'link_[12]' could pass through 'bar'"):
        steps(plant, 100, [0.0])


def test_lost_object_is_named_with_the_time() -> None:
    plant = world_of(Scene(objects=(SceneObject("ball", Sphere(0.1), mass=1.0),)))
    state = plant.get_state()
    state[-7] = 1e6 + 5.0  # its height
    plant.set_state(state)
    with pytest.raises(
        SimulationError,
        match=r"at t = .* 'ball' is at .* m .* outside of the simulated space",
    ):
        plant.step([])


def test_diverging_robot_is_named_with_time_and_coordinate() -> None:
    plant = Plant(two_link_arm(), scene=replace(ARM, ground=Ground(-5.0)))
    with pytest.raises(SimulationError, match=r"'arm' diverged at t = .* joint_\d"):
        steps(plant, 100, [1e300])


def test_substeps_divide_the_worlds_step() -> None:
    """Ten substeps of 1 ms equal ten steps of 1 ms."""
    coarse, fine = (
        world_of(falling_boxes(), 1e-3),
        Plant(block(), 1e-2, substeps=10, scene=falling_boxes()),
    )
    let_run(coarse, 0.3)
    let_run(fine, 0.3)
    np.testing.assert_array_equal(coarse.world.object_poses(), fine.world.object_poses())


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_wrenches_on_links_do_the_work_of_their_torques(integrator: str) -> None:
    """Compare tau = J'(F, T) for link 2 with finite differences of the pose."""
    robot = two_link_arm()
    q = np.array([0.4, -0.7])
    wrench = np.array([3.0, 1.0, -2.0, 0.3, 0.5, -0.2])

    def origin(angles: np.ndarray) -> np.ndarray:
        return np.array([-0.3 * np.sin(angles[0]), 0.0, 0.7 - 0.3 * np.cos(angles[0])])

    slope = [(origin(q + d) - origin(q - d)) / 2e-6 for d in 1e-6 * np.eye(2)]
    tau = np.array([wrench[:3] @ column + wrench[4] for column in slope])  # the joint axes are y
    pushed = Plant(robot, integrator=integrator, wrenched=("link_2",))  # type: ignore[arg-type]
    torqued = Plant(with_coordinates(robot, actuated=True), integrator=integrator)  # type: ignore[arg-type]
    for plant in (pushed, torqued):
        plant.reset(q)
    pushed.step([0.0], wrenches=wrench)
    torqued.step([0.0], torques=tau)
    np.testing.assert_allclose(pushed.qd, torqued.qd, rtol=1e-6, atol=1e-6)
    assert np.abs(pushed.qd).max() > 1e-3


def test_wrench_acts_on_the_correct_robot() -> None:
    robot = three_arms(2.0)
    plant = Plant(robot, scene=Scene(), wrenched=("link_1_1",))
    plant.step([], wrenches=[0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    moved = np.abs(plant.qd) > 1e-9
    np.testing.assert_array_equal(moved, [False, False, True, True, False, False])


@pytest.mark.slow
def test_stacked_boxes_keep_their_height() -> None:
    """Stacked boxes do not move."""
    tower = tuple(
        SceneObject(f"b{k}", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.05 + 0.1 * k)), 0.2)
        for k in range(4)
    )
    poses = let_run(world_of(Scene(Ground(), tower)), 1.0)
    heights = [0.05 + 0.1 * k for k in range(4)]
    np.testing.assert_allclose(poses[-1, :, 2], heights, atol=1e-4)
    np.testing.assert_allclose(poses[-1, :, :2], 0.0, atol=1e-4)


@pytest.mark.slow
def test_ball_rolls_down_a_slope() -> None:
    """The acceleration is 5/7 g sin(angle) without slip."""
    angle = np.radians(10.0)
    tilt = (0.0, angle, 0.0)
    ramp = SceneObject("ramp", Box((6.0, 1.0, 0.2)), Pose(rpy=tilt))
    up = np.array([np.sin(angle), 0.0, np.cos(angle)])
    ball = SceneObject("ball", Sphere(0.05), Pose(tuple((0.15 * up).tolist())), 0.3)
    poses = let_run(world_of(Scene(objects=(ramp, ball), friction=1.0)), 1.0)[:, 0]
    way = np.linalg.norm(poses[-1, :3] - 0.15 * up)
    assert way == pytest.approx(0.5 * 5 / 7 * G * np.sin(angle), rel=5e-3)


def test_two_balls_exchange_velocities_in_a_central_collision() -> None:
    balls = tuple(
        SceneObject(name, Capsule(0.05, 0.1), Pose((x, 0, 0)), 0.3, (v, 0.0, 0.0))
        for name, x, v in (("a", -0.2, 1.0), ("b", 0.2, -0.5))
    )
    robot = replace(block(), gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot, scene=Scene(objects=balls, restitution=1.0, friction=0.0))
    poses = let_run(plant, 0.6)[:, :, 0]
    speeds = (poses[-1] - poses[-101]) / 0.1
    np.testing.assert_allclose(speeds, [-0.5, 1.0], atol=5e-3)
