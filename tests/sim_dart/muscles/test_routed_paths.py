"""Paths with conditions, moving points, branches, terms, and wrap rules of MuJoCo and OpenSim."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from support.oracles.mujoco_tendons import robot_of_tendons
from support.robots.wrapped import FAR, carriage

from addin_sdfusion.robot import (
    WORLD,
    BasePulley,
    Branch,
    CardsflowError,
    CoordinateTerm,
    Muscle,
    PointCondition,
    PointMotion,
    Polynomial,
    Robot,
    SimmSpline,
    ViaPoint,
    Wrap,
    WrapSurface,
    read_robot,
)
from addin_sdfusion.robot.model.function import value
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

A, B = ViaPoint(WORLD, (-1.0, 0.1, 0.0)), ViaPoint(FAR, (1.0, 0.0, 0.2))
MIDDLE = ViaPoint("link_1", (0.1, 0.8, 0.3))
SPLINE = SimmSpline((-1.0, -0.2, 0.3, 1.0), (0.0, 0.3, -0.1, 0.2))


def _differences(paths: MusclePaths, q: FloatArray) -> FloatArray:
    """Return dl/dq by central differences of fourth order."""
    columns = []
    for step in 1e-3 * np.eye(len(q)):
        near, far = ((paths.evaluate(q + k * step).lengths.copy(),
                      paths.evaluate(q - k * step).lengths.copy()) for k in (1, 2))  # fmt: skip
        columns.append((8 * (near[0] - near[1]) - (far[0] - far[1])) / (12e-3))
    return np.array(columns).T


def assert_gradient_equals_differences(robot: Robot, q: FloatArray) -> None:
    paths = MusclePaths(robot)
    jacobian = paths.evaluate(q).jacobian.copy()
    np.testing.assert_allclose(jacobian, _differences(paths, q), atol=1e-8)


def _point(robot: Robot, q: FloatArray, via: ViaPoint) -> FloatArray:
    """Return the world position of a point of a carriage with axes x, y and z."""
    moved = {WORLD: 0, "link_0": 1, "link_1": 2, "link_2": 3}[via.link]
    return np.array(via.position) + np.array([*q[:moved], *[0.0] * (3 - moved)])


@pytest.mark.parametrize("at", [-0.7, -0.2, 0.4])
def test_paths_that_depend_on_a_fixed_coordinate(at: float) -> None:
    """A fixed coordinate has the same effect as a moving coordinate with the same value."""
    when, motion = (
        PointCondition("joint_0", -0.5, 0.25),
        PointMotion((0.0, 0.0, 1.0), "joint_0", SPLINE),
    )
    moved = replace(MIDDLE, position=(0.3, 0.5, 0.1), moves=(replace(motion, low=-0.5, high=0.3),))
    terms = (CoordinateTerm("joint_1", -0.2), CoordinateTerm("joint_0", 0.3))
    muscles = [
        Muscle("m", (A, replace(MIDDLE, when=when), moved, B), f_max=1.0),
        Muscle("s", (A, B), f_max=1.0, terms=terms),
    ]
    free = carriage(muscles, [])
    joint, *others = free.joints
    (c,) = joint.coordinates
    stays = replace(joint, coordinates=(replace(c, locked=True, initial=at),))
    held = MusclePaths(replace(free, joints=(stays, *others)))
    q = np.array([0.2, -0.3])
    there = MusclePaths(free).evaluate([at, *q])
    expected, L = there.lengths.copy(), there.jacobian.copy()
    np.testing.assert_allclose(held.evaluate(q).lengths, expected, rtol=1e-15)
    np.testing.assert_allclose(held.evaluate(q).jacobian, L[:, 1:], atol=1e-15)


def _around(p: FloatArray, q: FloatArray, radius: float) -> float:
    """Return the length from p to q around a circle about the origin."""
    cosine = p @ q / (np.linalg.norm(p) * np.linalg.norm(q))
    reach = [math.sqrt(x @ x - radius**2) for x in (p, q)]
    turns = [math.acos(radius / np.linalg.norm(x)) for x in (p, q)]
    return float(sum(reach) + radius * (math.acos(cosine) - sum(turns)))


@pytest.mark.parametrize(("shape", "wrapped"), [("cylinder", 0), ("sphere", 1)])
def test_opensim_uses_the_first_segment_over_cylinders(shape: str, wrapped: int) -> None:
    """Both segments intersect the surface, the first one deeper."""
    places = np.array([(-1.0, 0.05), (1.0, 0.1), (-1.0, -0.45)])
    surface = WrapSurface("ball", WORLD, shape, 0.3)  # type: ignore[arg-type]
    wrap = Wrap("ball", 0, rule="opensim", last_segment=1)
    links = (WORLD, "link_0", WORLD)
    points = (ViaPoint(link, (x, y, 0.0)) for link, (x, y) in zip(links, places, strict=True))
    muscle = Muscle("m", tuple(points), f_max=1.0, wraps=(wrap,))
    (length,) = MusclePaths(carriage([muscle], [surface])).evaluate(np.zeros(3)).lengths
    ways = [math.dist(*places[k : k + 2]) for k in range(2)]
    ways[wrapped] = _around(places[wrapped], places[wrapped + 1], 0.3)
    assert length == pytest.approx(sum(ways), rel=1e-14)


def test_conditional_via_points() -> None:
    """The length jumps at the ends of the range, or is blended, with the matching gradient."""
    when = PointCondition("joint_0", -0.5, 0.25)
    robot = carriage([Muscle("m", (A, replace(MIDDLE, when=when), B), f_max=1.0)], [])
    smooth = carriage(
        [Muscle("m", (A, replace(MIDDLE, when=replace(when, smoothing=0.5)), B), f_max=1.0)], []
    )
    for x in (-1.1, -0.9, -0.6, -0.5, 0.0, 0.25, 0.3, 0.6, 0.8):
        q = np.array([x, 0.2, -0.3])
        a, p, b = (_point(robot, q, via) for via in (A, MIDDLE, B))
        with_it, without = math.dist(a, p) + math.dist(p, b), math.dist(a, b)
        expected = with_it if -0.5 <= x <= 0.25 else without
        assert MusclePaths(robot).evaluate(q).lengths[0] == pytest.approx(expected, rel=1e-15)
        s = 1.0 - min(max(-0.5 - x, x - 0.25, 0.0) / 0.5, 1.0)
        share = s**3 * (10 - 15 * s + 6 * s * s)
        blended = share * with_it + (1.0 - share) * without
        assert MusclePaths(smooth).evaluate(q).lengths[0] == pytest.approx(blended, rel=1e-14)
        if x not in (-0.5, 0.25):  # differences are inaccurate if the third derivative jumps
            assert_gradient_equals_differences(smooth, q)


def test_unsupported_paths_are_rejected() -> None:
    when = PointCondition("joint_0", -0.5, 0.25)
    smooth = replace(MIDDLE, when=replace(when, smoothing=0.5))
    pulley = BasePulley("rotating", (("pulley_radius", (0.1,)), ("cable_entry_vector", (0, 0, 1))))
    ball = WrapSurface("ball", WORLD, "sphere", 0.05)
    egg = WrapSurface("egg", WORLD, "ellipsoid", 0.05, half_axes=(0.04, 0.003))
    for muscle, what in (
        (Muscle("m", (A, smooth, B), f_max=1.0, wraps=(Wrap("ball", 0),)), "smoothed"),
        (Muscle("m", (A, replace(MIDDLE, when=when), B), f_max=1.0, pulley=pulley), "pulley"),
        (Muscle("m", (A, B), f_max=1.0, wraps=(Wrap("egg", 0),)), "ellipsoid 'egg'"),
    ):
        with pytest.raises(
            CardsflowError, match=f"^muscle 'm': .*{what}.* is not supported in simulation"
        ):
            MusclePaths(carriage([muscle], [ball, egg]))


def test_moving_points_branches_and_terms() -> None:
    """Compare with the definition. The gradient includes the motion of the points."""
    moves = (
        PointMotion((1.0, 0.0, 0.5), "joint_1", SPLINE, -0.8, 0.8),
        PointMotion((0.0, 1.0, 0.0), "joint_2", Polynomial((0.1, 0.5, -0.3, 0.2))),
    )
    moving = replace(MIDDLE, moves=moves)
    points = (A, moving, B, MIDDLE, B, ViaPoint("link_0", (0.0, 0.0, 2.0)))
    terms = (CoordinateTerm("joint_0", 0.3), CoordinateTerm("joint_2", -0.2))
    branches = (Branch(3, 2.0),)
    robot = carriage(
        [
            Muscle("m", points, f_max=1.0, branches=branches, terms=terms),
            Muscle("fixed", (), f_max=1.0, terms=terms),
            Muscle("plain", (A, B), f_max=1.0),
        ],
        [],
    )
    rng = np.random.default_rng(3)
    for q in rng.uniform(-0.7, 0.7, (5, 3)):
        own = _point(robot, q, MIDDLE) + np.array([1.0, 0.0, 0.5]) * value(SPLINE, q[1])
        own[1] += 0.1 + 0.5 * q[2] - 0.3 * q[2] ** 2 + 0.2 * q[2] ** 3
        a, p, b, end = (_point(robot, q, via) for via in (A, MIDDLE, B, points[-1]))
        expected = math.dist(a, own) + math.dist(own, b)
        expected += (math.dist(p, b) + math.dist(b, end)) / 2.0 + 0.3 * q[0] - 0.2 * q[2]
        lengths = MusclePaths(robot).evaluate(q).lengths
        assert lengths[0] == pytest.approx(expected, rel=1e-14)
        assert lengths[1] == pytest.approx(0.3 * q[0] - 0.2 * q[2], abs=1e-16)
        assert lengths[2] == pytest.approx(math.dist(a, b), rel=1e-15)
        assert_gradient_equals_differences(robot, q)


def test_moving_point_is_constant_outside_its_range() -> None:
    move = PointMotion((0.0, 1.0, 0.0), "joint_0", Polynomial((0.0, 1.0)), -0.5, 0.5)
    robot = carriage([Muscle("m", (A, replace(MIDDLE, moves=(move,)), B), f_max=1.0)], [])
    q = np.array([0.9, 0.1, 0.2])
    a, p, b = (_point(robot, q, via) for via in (A, MIDDLE, B))
    p[1] += 0.5
    lengths = MusclePaths(robot).evaluate(q).lengths
    assert lengths[0] == pytest.approx(math.dist(a, p) + math.dist(p, b), rel=1e-15)
    assert_gradient_equals_differences(robot, q)


def _random_tendons(seed: int) -> str:
    """Return a body that slides along three axes, with tendons over geoms of the world."""
    rng = np.random.default_rng(seed)
    world, body, tendons = [], [], []
    for k in range(150):
        shape = "sphere" if k % 2 else "cylinder"
        radius = rng.uniform(0.1, 0.4)
        angles = " ".join(map(str, rng.uniform(-3.0, 3.0, 3)))
        world.append(f'<geom name="g{k}" type="{shape}" size="{radius} 0.3" euler="{angles}"/>')
        for name, place in (("a", world), ("b", body), ("s", world)):
            at = rng.normal(size=3)
            at *= rng.uniform(0.02 if name == "s" else radius, 1.2) / np.linalg.norm(at)
            place.append(f'<site name="{name}{k}" pos="{at[0]} {at[1]} {at[2]}"/>')
        side = f'sidesite="s{k}"' if k % 3 else ""
        pulley = '<pulley divisor="2.5"/>' if k % 4 == 0 else ""
        tendons.append(
            f'<spatial name="t{k}">{pulley}<site site="a{k}"/><geom geom="g{k}" {side}/>'
            f'<site site="b{k}"/></spatial>'
        )
    slides = "".join(f'<joint type="slide" axis="{a}"/>' for a in ("1 0 0", "0 1 0", "0 0 1"))
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{"".join(world)}'
        f'<body>{slides}<geom size="0.01"/>{"".join(body)}</body></worldbody>'
        f"<tendon>{''.join(tendons)}"
        '<fixed name="sum"><joint joint="joint_0" coef="0.5"/></fixed></tendon></mujoco>'
    ).replace('<joint type="slide" axis="1', '<joint name="joint_0" type="slide" axis="1')


def _compare(model: mujoco.MjModel, poses: FloatArray) -> int:
    """Compare and return the number of contacts; Jacobians of inside wraps agree to 1e-6."""
    data, paths, on_surfaces = mujoco.MjData(model), MusclePaths(robot_of_tendons(model)), 0
    for q in poses:
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        state = paths.evaluate(q)
        np.testing.assert_allclose(state.lengths, data.ten_length, atol=1e-11)
        jacobian = np.zeros((model.ntendon, model.nv))
        for t in range(model.ntendon):
            first, count = model.ten_J_rowadr[t], model.ten_J_rownnz[t]
            columns = model.ten_J_colind[first : first + count]
            jacobian[t, columns] = data.ten_J[first : first + count]
        np.testing.assert_allclose(state.jacobian, jacobian, atol=1e-6)
        on_surfaces += int((data.wrap_obj >= 0).sum())
    return on_surfaces


def test_mujoco_tendons() -> None:
    """Check random spheres, cylinders, side points, inside wraps, and pulleys."""
    model = mujoco.MjModel.from_xml_string(_random_tendons(1))
    assert _compare(model, np.random.default_rng(2).normal(size=(6, 3)) * 0.5) > 500


@pytest.mark.parametrize("name", ["myoelbow_2dof6muscles", "myofinger_v0", "myohand", "myoarm"])
def test_published_tendons(shared: Path, name: str) -> None:
    model = mujoco.MjModel.from_xml_path(str(shared / f"models/mjcf/{name}.xml"))
    content = json.loads((shared / f"reference/mjcf/{name}.json").read_text())
    assert _compare(model, np.array([pose["qpos"] for pose in content["poses"]])) > 20


@pytest.mark.parametrize("name", ["myohand", "myoarm"])
def test_rates_and_torques_contain_all_coordinates_of_a_path(shared: Path, name: str) -> None:
    """The core skips coordinates that a muscle does not depend on."""
    robot, rng = read_robot(shared / f"models/mjcf/{name}.xml"), np.random.default_rng(4)
    paths = MusclePaths(robot)
    core, muscles = paths.core, len(robot.muscles)
    qd, forces = rng.normal(size=len(robot.coordinates)), rng.uniform(1.0, 9.0, muscles)
    L = paths.evaluate(rng.uniform(0.0, 0.3, qd.size)).jacobian
    core.rates(core.handle, qd.tobytes())
    core.pull(core.handle, forces.tobytes())
    np.testing.assert_allclose(core.array("rates", muscles), L @ qd, rtol=0, atol=1e-14)
    np.testing.assert_allclose(core.array("torques", qd.size), -L.T @ forces, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "name", ["arm26", "gait10dof18musc", "leg6dof9musc", "gait2392_thelen2003muscle",
             "subject_walk_scaled"]
)  # fmt: skip
def test_published_opensim_paths(shared: Path, name: str) -> None:
    """Compare straight paths and single cylinders to 1e-9 m, the others to 5e-4 m."""
    robot = read_robot(shared / f"models/opensim/{name}.osim")
    paths = MusclePaths(robot)
    content = json.loads((shared / f"reference/opensim/{name}.json").read_text())
    names = [coordinate["name"] for coordinate in content["coordinates"]]
    theirs = {muscle["name"]: i for i, muscle in enumerate(content["muscles"])}
    for pose in content["poses"]:
        q = dict(zip(names, pose["q"], strict=True))
        lengths = paths.evaluate([q[c.name] for c in robot.coordinates]).lengths
        for muscle, length in zip(robot.muscles, lengths, strict=True):
            i = theirs[muscle.name]
            exact = pose["exact_cylinder_length"][i] if muscle.wraps else pose["length"][i]
            if content["muscles"][i]["ellipsoid"]:
                disagrees = (
                    pose["fd_disagreement"][i] > 1e-3
                )  # OpenSim contradicts its own differences
                assert disagrees or length == pytest.approx(pose["length"][i], abs=1e-4)
            elif exact is not None:
                assert length == pytest.approx(exact, rel=1e-9)
                assert length == pytest.approx(pose["length"][i], abs=5e-4)
