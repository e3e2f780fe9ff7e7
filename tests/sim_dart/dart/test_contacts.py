"""Contacts of resting, sliding, grasped and bouncing bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.robots.worlds import SHAPES, G, let_run, pincers, shape, world_of

from addin_sdfusion.robot import Pose
from addin_sdfusion.robot.model.rotations import rotation
from sim_dart import Plant
from sim_dart.scene import Box, Ground, Scene, SceneObject

MASS = 0.5


def resting_body(kind: str, folder: Path, **surface: float) -> tuple[Plant, float]:
    """Return a plant with a body 2 mm above the ground, and half the height of the body."""
    form, half = shape(kind, folder)
    body = SceneObject("body", form, Pose((0.3, -0.2, half + 0.002)), mass=MASS)
    scene = Scene(Ground(), (body,), reported=("body", "ground"), **surface)  # type: ignore[arg-type]
    return world_of(scene), half


@pytest.mark.slow
@pytest.mark.parametrize("kind", SHAPES)
def test_every_shape_rests_on_the_ground(kind: str, tmp_path: Path) -> None:
    plant, half = resting_body(kind, tmp_path)
    z = let_run(plant, 1.0)[:, 0, 2] - half
    assert abs(z[-1]) < 1e-6 + (1e-3 if kind == "fine mesh" else 0.0)  # it rests on a facet
    impact = np.sqrt(2 * G * 0.002) * plant.step_size  # largest overlap is the fall in one step
    assert z.min() > -impact - (1e-3 if kind == "fine mesh" else 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [kind for kind in SHAPES if kind != "fine mesh"])  # it rocks
def test_contact_forces_equal_the_weight(kind: str, tmp_path: Path) -> None:
    """Check the mean, since contact points of a cylinder change."""
    plant, _ = resting_body(kind, tmp_path)
    let_run(plant, 0.8)
    rows = []
    for _ in range(200):
        plant.step([])
        rows.append(plant.world.contact_forces())
    forces = np.array(rows)
    np.testing.assert_allclose(forces[:, 0].mean(axis=0), [0.0, 0.0, MASS * G], atol=1e-3)
    np.testing.assert_allclose(forces[:, 1], -forces[:, 0], atol=1e-12)
    assert {(c.first, c.second) for c in plant.world.contacts()} <= {
        ("body", "ground"),
        ("ground", "body"),
    }


def slide_body(
    kind: str, direction: float, folder: Path, law: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return sliding distances along and across the initial direction, and Coulomb's distance.

    With semi-implicit Euler, x_k is the sum of h v_k, with v_k = v0 - k h mu g.
    """
    mu, speed = 0.4, 1.0
    angle = np.radians(direction)
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    form, half = shape(kind, folder)
    start = Pose((0.0, 0.0, half))
    body = SceneObject("body", form, start, MASS, tuple(speed * along), friction=mu)
    scene = Scene(Ground(friction=0.9), (body,), friction_law=law)  # type: ignore[arg-type]
    plant = world_of(scene)  # the contact uses the smaller friction
    poses = let_run(plant, 0.1)
    times = plant.step_size * np.arange(1, len(poses) + 1)
    expected = speed * times - 0.5 * mu * G * times * (times + plant.step_size)
    across = [-along[1], along[0]]
    way = np.stack([poses[:, 0, :2] @ along[:2], poses[:, 0, :2] @ across], axis=1)
    return way, expected


@pytest.mark.parametrize("direction", [0.0, 90.0, 180.0, 270.0])
@pytest.mark.parametrize("kind", ["box", "cylinder", "mesh"])
def test_sliding_body_decelerates_with_mu_g(kind: str, direction: float, tmp_path: Path) -> None:
    way, expected = slide_body(kind, direction, tmp_path, "pyramid")
    step = 0.4 * G * 1e-3**2  # friction can start one step late
    np.testing.assert_allclose(way[:, 0], expected, atol=1.01 * step)
    np.testing.assert_allclose(way[:, 1], 0.0, atol=1e-9)


@pytest.mark.parametrize("direction", [0.0, 22.5, 45.0, 70.0, 200.0])
@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_friction_cones_decelerate_equally_in_every_direction(
    kind: str, direction: float, tmp_path: Path
) -> None:
    way, expected = slide_body(kind, direction, tmp_path, "cone")
    np.testing.assert_allclose(way[:, 0], expected, atol=1e-4)
    np.testing.assert_allclose(way[:, 1], 0.0, atol=1e-3)


def test_friction_pyramid_is_too_large_by_sqrt_2_between_axes(tmp_path: Path) -> None:
    """This error of DART is documented in the description of the setting."""
    way, expected = slide_body("box", 45.0, tmp_path, "pyramid")
    slowed, coulomb = 0.1 - way[-1, 0], 0.1 - expected[-1]
    assert slowed == pytest.approx(np.sqrt(2.0) * coulomb, rel=1e-3)


@pytest.mark.slow
def test_stack_rests_with_friction_cones() -> None:
    """Bodies overlap by 1e-5 m. The stack falls if the solver does not converge."""
    boxes = tuple(
        SceneObject(f"box {k}", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.05 + 0.1 * k)), MASS)
        for k in range(4)
    )
    plant = world_of(Scene(Ground(), boxes, friction=0.5, friction_law="cone"))
    poses = let_run(plant, 0.4)
    assert np.abs(poses[-1, :, :3] - poses[0, :, :3]).max() < 3e-5


@pytest.mark.slow
def test_sliding_body_stops_at_the_distance_of_coulombs_law() -> None:
    mu, speed = 0.5, 1.5
    body = SceneObject("body", Box((0.2, 0.2, 0.1)), Pose((0.0, 0.0, 0.05)), MASS, (speed, 0, 0))
    plant = world_of(Scene(Ground(), (body,), friction=mu))
    x = let_run(plant, 1.0)[:, 0, 0]
    assert x[-1] == pytest.approx(speed**2 / (2 * mu * G), abs=speed * plant.step_size)
    assert abs(x[-1] - x[600]) < 1e-6


@pytest.mark.parametrize("law", ["pyramid", "cone"])
@pytest.mark.parametrize(("mu", "slides"), [(0.52, True), (0.64, False)])
def test_body_slides_on_slope_if_friction_is_below_tan_30(
    mu: float, slides: bool, law: str
) -> None:
    """The critical friction is tan 30° = 0.577."""
    tilt = (0.0, np.radians(30.0), np.radians(45.0 if law == "cone" else 0.0))
    ramp = SceneObject("ramp", Box((4.0, 4.0, 0.2)), Pose((0.0, 0.0, 0.0), tilt))
    up = np.array(rotation(tilt)) @ [0.0, 0.0, 0.15]
    body = SceneObject("body", Box((0.1, 0.1, 0.1)), Pose(tuple(up), tilt), MASS)
    poses = let_run(
        world_of(Scene(None, (ramp, body), friction=mu, friction_law=law)),  # type: ignore[arg-type]
        0.5,
    )
    way = np.linalg.norm(poses[-1, 0, :3] - up)
    expected = 0.5 * G * (np.sin(np.radians(30)) - mu * np.cos(np.radians(30))) * 0.5**2
    assert way == pytest.approx(expected, rel=0.02) if slides else way < 1e-4


@pytest.mark.cases(6)
@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.6, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("kind", SHAPES)
def test_bounce_height_is_proportional_to_restitution_squared(
    kind: str, restitution: float, tmp_path: Path
) -> None:
    form, half = shape(kind, tmp_path)
    drop = 0.5
    body = SceneObject("body", form, Pose((0.0, 0.0, half + drop)), MASS)
    plant = world_of(Scene(Ground(), (body,), restitution=restitution), 2e-4)
    z = let_run(plant, 1.0)[:, 0, 2] - half
    lowest = int(np.argmin(z[:2000]))
    reached = z[lowest:].max()
    facet = 1e-3 if kind == "fine mesh" else 0.0
    assert reached == pytest.approx(restitution**2 * drop, rel=5e-3, abs=facet)


@pytest.mark.slow
def test_contact_uses_geometric_mean_of_restitutions() -> None:
    ball = SceneObject("ball", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.55)), MASS, restitution=0.5)
    plant = world_of(Scene(Ground(restitution=0.72), (ball,)), 2e-4)
    z = let_run(plant, 0.8)[:, 0, 2] - 0.05
    assert z[int(np.argmin(z[:2000])) :].max() == pytest.approx(0.5 * 0.72 * 0.5, rel=5e-3)


def test_no_restitution_means_no_bounce() -> None:
    ball = SceneObject("ball", Box((0.1, 0.1, 0.1)), Pose((0.0, 0.0, 0.55)), MASS, restitution=0.0)
    z = let_run(world_of(Scene(Ground(restitution=1.0), (ball,))), 0.8)[:, 0, 2] - 0.05
    assert z[400:].max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pyramid", "cone"])
def test_two_fingers_grasp_lift_and_release_a_box(law: str) -> None:
    robot, pads = pincers()
    box = SceneObject("box", Box((0.04, 0.06, 0.04)), mass=0.3)
    reported = ("left", "right", "box")
    scene = Scene(None, (box,), 0.8, friction_law=law, link_shapes=pads, reported=reported)  # type: ignore[arg-type]
    plant = Plant(robot, scene=scene)
    # the robot weighs 1.4 kg, the box 0.3 kg; the fingers start at +-0.1 m and close to 0.04 m
    plant.reset([0.0, 0.058, -0.058])
    lifting, squeeze = 1.7 * G, 5.0
    names = [muscle.name for muscle in robot.muscles]
    closed = np.zeros(len(names))
    closed[names.index("up")] = lifting + 2.0
    closed[[names.index("close_left"), names.index("close_right")]] = squeeze
    let_run(plant, 0.4, closed)
    carriage = plant.q[0]
    assert carriage > 0.04
    z = plant.world.object_poses()[0, 2]
    assert (
        abs(z - carriage) < 2e-3
    )  # the box follows the carriage and slips only while the fingers close
    forces = plant.world.contact_forces()
    np.testing.assert_allclose(forces[0] + forces[1] + forces[2], 0.0, atol=1e-9)
    rising = 0.3 * G + 0.3 * _acceleration(plant, closed)
    assert forces[2, 2] == pytest.approx(rising, rel=1e-2)
    assert abs(forces[0, 1]) == pytest.approx(squeeze, rel=0.05)
    before = plant.world.object_poses()[0, 2]
    opened = np.zeros(len(names))
    opened[names.index("up")] = 1.4 * G
    opened[[names.index("open_left"), names.index("open_right")]] = squeeze
    let_run(plant, 0.4, opened)
    assert plant.world.object_poses()[0, 2] < before - 0.3
    np.testing.assert_array_equal(plant.world.contact_forces()[2], 0.0)


def _acceleration(plant: Plant, forces: np.ndarray) -> float:
    """Return the acceleration of the box from one additional step."""
    state, before = plant.get_state(), plant.qd[0]
    plant.step(forces)
    change = (plant.qd[0] - before) / plant.step_size
    plant.set_state(state)
    plant.step(forces)
    plant.set_state(state)
    return float(change)


def test_box_slips_with_too_little_friction() -> None:
    robot, pads = pincers()
    box = SceneObject("box", Box((0.04, 0.06, 0.04)), mass=0.3)
    plant = Plant(robot, scene=Scene(None, (box,), friction=0.2, link_shapes=pads))
    plant.reset([0.0, 0.06, -0.06])  # the fingers touch it
    names = [muscle.name for muscle in robot.muscles]
    squeeze, duration = 5.0, 0.15
    f = np.zeros(len(names))
    f[names.index("up")] = 1.4 * G
    f[[names.index("close_left"), names.index("close_right")]] = squeeze
    z = let_run(plant, duration, f)[:, 0, 2]
    drop = 0.5 * (G - 2 * 0.2 * squeeze / 0.3) * duration**2  # 2 N hold, 2.9 N pull
    assert z[-1] == pytest.approx(-drop, rel=0.03)
