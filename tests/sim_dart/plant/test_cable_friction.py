"""Cable friction at bends: capstan equation, virtual work, energy, and DART."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.robots.one_link import one_link
from support.robots.random_robots import random_tree
from support.robots.wrapped import base_pulley

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    CardsflowError,
    Inertia,
    InputError,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
    prismatic,
)
from addin_sdfusion.robot.model.muscle_laws import PRESETS, law_parameters
from addin_sdfusion.robot.model.rotations import rotation
from sim_dart import Plant
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

MU, F, MASS, STEP = 0.15, 10.0, 2.0, 1e-3
Case = tuple[Robot, float]


def slider(
    *points: tuple[float, float, float],
    end: float = 0.0,
    wraps: tuple[Wrap, ...] = (),
    surfaces: tuple[WrapSurface, ...] = (),
    **more: Any,
) -> Robot:
    """Return a mass on a rail along x, which a cable pulls through points of the world."""
    path = (*(ViaPoint(WORLD, p) for p in points), ViaPoint("a", (0.0, end, 0.0)))
    muscle = Muscle("m", path, 0.0, 1e4, friction=MU, wraps=wraps, **more)
    inertia = Inertia(MASS, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)
    robot = one_link(inertia, [muscle], surfaces, prismatic((1.0, 0.0, 0.0)), initial=1.0)
    return replace(robot, gravity=(0.0, 0.0, 0.0))


def corners() -> Case:
    """Return a cable with bends of 90 and 135 degrees."""
    return slider((0.1, -0.1, 0.0), (-0.1, 0.1, 0.0), (-0.2, 0.0, 0.0)), 5 * math.pi / 4


def around_a_corner(shape: Any, climb: float = 0.0) -> Case:
    """Return a cable over a quarter of a circle of 0.4 m, helical on a cylinder."""
    surface = WrapSurface("round", WORLD, shape, 0.4, Pose((0.4, -0.4, 0.0)))
    start = (0.0, -0.6, -climb)
    robot = slider(start, wraps=(Wrap("round", 0, 0),), surfaces=(surface,))
    across = 0.2 + 0.6 + 0.4 * math.pi / 2
    return robot, math.pi / 2 * across / math.hypot(across, climb)


def around_an_ellipsoid(x: float, y: float, z: float) -> Case:
    """Return a cable over a quarter of an ellipse."""
    egg = WrapSurface("egg", WORLD, "ellipsoid", x, Pose((x, -y, 0.0)), half_axes=(y, z))
    wraps, start = (Wrap("egg", 0),), (0.0, -y - 0.1, 0.0)
    return slider(start, wraps=wraps, surfaces=(egg,)), math.pi / 2


def from_an_ellipsoid() -> Case:
    """Return a cable over an ellipsoid to one of its points and to the slider."""
    egg = WrapSurface("egg", WORLD, "ellipsoid", 0.4, Pose((0.0, -0.3, 0.0)), half_axes=(0.3, 0.6))
    points = ((-0.4, -0.6, 0.0), (0.0, 0.0, 0.0))
    return slider(*points, wraps=(Wrap("egg", 0),), surfaces=(egg,)), math.pi / 2


def through_a_tube() -> Case:
    """Return a cable through a tube, which it touches in the middle, below both ends."""
    tube = WrapSurface("tube", WORLD, "cylinder", 0.05, Pose((0.0, 0.15, 0.0)))
    wraps = (Wrap("tube", 0, inside=True),)
    robot = slider((-1.0, 0.3, 0.0), end=0.3, wraps=wraps, surfaces=(tube,))
    return robot, 2 * math.atan2(0.1, 1.0)


def over_a_pulley() -> Case:
    """Return a cable over a pulley of 0.1 m at the base."""
    return slider((-0.1, 0.1, 0.0), pulley=base_pulley(0.1, (0.0, -1.0, 0.0))), math.pi / 2


CASES = {
    "corners": corners,
    "cylinder": lambda: around_a_corner("cylinder"),
    "sphere": lambda: around_a_corner("sphere"),
    "climbing": lambda: around_a_corner("cylinder", 0.4),
    "ellipsoid": lambda: around_an_ellipsoid(0.4, 0.3, 0.6),
    "ball": lambda: around_an_ellipsoid(0.4, 0.4, 0.4),
    "on an ellipsoid": from_an_ellipsoid,
    "inside": through_a_tube,
    "pulley": over_a_pulley,
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_sliding_cable_follows_the_capstan_equation(case: str, way: float) -> None:
    """The tension at the mass is f exp(+-mu theta)."""
    robot, theta = CASES[case]()
    plant = Plant(robot, STEP)
    slide(plant, way)
    plant.hold([F])
    far = F * math.exp(way * MU * theta)
    assert plant.far_tensions[0] == pytest.approx(far, rel=1e-12)
    before, span = plant.qd[0], last_span(plant)
    plant.step([F])
    assert plant.qd[0] - before == pytest.approx(-STEP * far * span / MASS, rel=1e-12)


def with_separate_friction(
    robot: Robot, points: list[float | None], wraps: list[float | None]
) -> Robot:
    """Return the robot with separate coefficients of via points and wraps."""
    muscle = robot.muscles[0]
    given = [*points, *[None] * (len(muscle.via_points) - len(points))]
    changed = replace(
        muscle,
        via_points=tuple(map(_set_friction, muscle.via_points, given)),
        wraps=tuple(map(_set_friction, muscle.wraps, wraps)),
    )
    return robot.with_muscles([changed])


def _set_friction(bend: Any, friction: float | None) -> Any:
    return replace(bend, friction=friction)


def onto_a_drum() -> Robot:
    """Return a cable with 90 degrees at a point and 90 degrees over a cylinder."""
    drum = WrapSurface("drum", WORLD, "cylinder", 0.4, Pose((0.4, -0.4, 0.0)))
    points = ((0.3, -0.6, 0.0), (0.0, -0.6, 0.0))
    return slider(*points, wraps=(Wrap("drum", 1, 0),), surfaces=(drum,))


SEPARATE_FRICTION = {
    "points": (
        lambda: with_separate_friction(corners()[0], [None, 0.05, 0.3], []),
        0.05 * 2 + 0.3 * 3,
    ),
    "a point": (
        lambda: with_separate_friction(onto_a_drum(), [None, 0.4], [None]),
        0.4 * 2 + MU * 2,
    ),
    "a surface": (lambda: with_separate_friction(onto_a_drum(), [], [0.4]), MU * 2 + 0.4 * 2),
    "a smooth one": (lambda: with_separate_friction(onto_a_drum(), [], [0.0]), MU * 2),
    "a pulley": (lambda: with_separate_friction(over_a_pulley()[0], [0.02], []), 0.02 * 2),
    "a guide": (
        lambda: with_separate_friction(through_a_tube()[0], [], [0.5]),
        4 / math.pi * math.atan2(0.1, 1.0),
    ),
}
"""Robots with the sum of mu theta in units of pi / 4."""


@pytest.mark.parametrize("case", SEPARATE_FRICTION)
def test_points_and_surfaces_can_have_separate_friction(case: str) -> None:
    """The tension is F exp(+- sum mu_i theta_i), with the coefficient of the muscle as default."""
    make, grip = SEPARATE_FRICTION[case]
    robot = make()
    for way in (1.0, -1.0):
        plant = Plant(robot, STEP)
        slide(plant, way)
        plant.hold([F])
        far = F * math.exp(way * grip * math.pi / 4)
        assert plant.far_tensions[0] == pytest.approx(far, rel=1e-12)


def slide(plant: Plant, way: float) -> None:
    """Move the mass from q = 1 until all bends slip in the given direction."""
    plant.reset([1.0])
    state, count = plant.get_state(), len(plant.muscle_state_names)
    state[2], state[3 : 3 + count] = 0.3 * way, way
    plant.set_state(state)


def last_span(plant: Plant) -> float:
    """Return dl/dq of the last span, the only one that moves with the mass."""
    return float(plant.muscle_jacobian[0, 0])


@pytest.mark.parametrize("inside", [False, True])
def test_wrap_angle_of_ellipsoid_is_that_of_its_geodesic(inside: bool) -> None:
    """Compare with the sum of angles along a geodesic from SciPy's integrator."""
    half, turned = np.array([0.3, 0.2, 0.15]), (0.3, 0.5, -0.4)
    egg = WrapSurface(
        "egg", WORLD, "ellipsoid", 0.3, Pose((0, 0, 0), turned), half_axes=(0.2, 0.15)
    )
    start = (-0.12, 0.02, 0.1) if inside else (-0.5, 0.3, 0.1)
    robot = slider(start, wraps=(Wrap("egg", 0),), surfaces=(egg,), end=-0.1)
    paths = MusclePaths(robot)
    paths.evaluate([0.6])
    contact = paths.core.array("wrap_contacts", 22)
    R = np.array(rotation(turned))
    x, v = R.T @ contact[12:15], R.T @ contact[3:6]
    scale = float(np.linalg.norm(x / half))
    assert (scale < 0.999) == inside
    A = 1 / (scale * half) ** 2
    v -= (A * x) * (v @ (A * x)) / ((A * x) @ (A * x))
    v /= np.linalg.norm(v)

    def bends(_: float, state: FloatArray) -> FloatArray:
        at, along = state[:3], state[3:6]
        bow = -(along @ (A * along)) / ((A * at) @ (A * at)) * (A * at)
        return np.concatenate([along, bow, [np.linalg.norm(bow)]])

    begin = np.concatenate([x, v, [0.0]])
    found = solve_ivp(bends, (0.0, contact[21]), begin, "DOP853", rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(R @ found.y[:3, -1], contact[15:18], atol=1e-10)
    grip = paths.core.array("bend_grip", 1)[0]
    assert grip == pytest.approx(MU * found.y[6, -1], rel=1e-10)


def test_mass_sticks_below_the_friction_limit() -> None:
    """A load below the friction limit does not move the mass."""
    robot, theta = corners()
    load = F * math.exp(0.5 * MU * theta)  # half of the load that causes slip
    joints = tuple(
        replace(j, coordinates=tuple(replace(c, damping=200.0) for c in j.coordinates))
        for j in robot.joints
    )
    plant = Plant(replace(robot, joints=joints, gravity=(load / MASS, 0.0, 0.0)), STEP, energy=True)
    for _ in range(4000):
        plant.step([F])
    held = plant.q[0]
    for _ in range(1000):
        plant.step([F])
    assert abs(plant.q[0] - held) < 1e-14
    assert 0 < held - 1.0 < 2e-4 * 3
    assert plant.far_tensions[0] == pytest.approx(load, rel=1e-12)


def span_tensions(paths: MusclePaths, robot: Robot, q: FloatArray, s: FloatArray) -> FloatArray:
    """Return generalised forces of unit tensions, with exp(mu angles) for each span."""
    state, bend, tau = q, 0, np.zeros(q.size)

    def spans(at: FloatArray) -> list[FloatArray]:
        return [np.diff(np.array(line), axis=0) for line in paths.path_points(at)]

    now = spans(state)
    slopes = []
    h = 1e-5
    for j in range(q.size):
        step = np.eye(q.size)[j] * h
        ends = [[np.linalg.norm(d, axis=1) for d in spans(state + k * step)] for k in (-1, 1)]
        slopes.append([(b - a) / (2 * h) for a, b in zip(*ends, strict=True)])
    for m, muscle in enumerate(robot.muscles):
        tension = 1.0
        for i, d in enumerate(now[m]):
            if i:
                u, v = now[m][i - 1], d
                angle = math.acos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))
                tension *= math.exp(muscle.bend_friction[i - 1] * angle * s[bend])
                bend += 1
            tau -= tension * np.array([slopes[j][m][i] for j in range(q.size)])
    return tau


@pytest.mark.parametrize("seed", range(4))
def test_every_span_has_its_own_tension(seed: int) -> None:
    """Compare -P'f with the virtual work of the spans on random trees."""
    rng = np.random.default_rng(seed)
    robot = random_tree(seed)
    robot = robot.with_muscles(
        [
            replace(
                m, via_points=tuple(_set_friction(p, rng.uniform(0.05, 0.4)) for p in m.via_points)
            )
            for m in robot.muscles
        ]
    )
    paths = MusclePaths(robot)
    q = rng.uniform(-1, 1, len(robot.coordinates))
    slips = paths.core.array("law_states", paths.bends)
    slips[:] = rng.uniform(-1, 1, paths.bends)
    tau = -paths.pulling(q).T @ np.ones(4)
    np.testing.assert_allclose(tau, span_tensions(paths, robot, q, slips.copy()), atol=1e-8)
    paths.evaluate(q)
    f = np.ones(4).tobytes()
    assert not paths.core.pull(paths.core.handle, f)
    np.testing.assert_allclose(paths.core.array("torques", q.size), tau, rtol=1e-13, atol=1e-13)


def test_no_step_adds_energy() -> None:
    """Check F dl - V(s+) + V(s) >= 0 for a million random bends, states and displacements."""
    rng = np.random.default_rng(1)
    E, s = rng.uniform(1e-3, 3.0, 1_000_000), rng.uniform(-1, 1, 1_000_000)
    x = rng.normal(size=s.size) * 10.0 ** rng.uniform(-6, 3, s.size)
    after = (s + x) / (1 + np.abs(x))
    stored = np.expm1(E * after) / E - after - (np.expm1(E * s) / E - s)
    lost = np.expm1(E * after) * x - stored
    assert (lost >= -1e-14 * (1 + np.abs(x))).all()


def test_energy_balance_includes_friction() -> None:
    """Work of the cable minus friction losses equals kinetic energy for random forces."""
    robot, _ = corners()
    plant, rng = Plant(robot, STEP, energy=True), np.random.default_rng(2)
    lost = [0.0]
    for _ in range(300):
        plant.reset([1.0], [rng.normal()]) if plant.q[0] < 0.2 or plant.q[0] > 3 else None
        start = plant.energy
        plant.step([abs(rng.normal()) * 100.0])
        now = plant.energy
        work = sum(now[2:]) - sum(start[2:])
        assert now.kinetic - start.kinetic == pytest.approx(work, abs=1e-12)
        assert now.friction_work <= start.friction_work
        lost.append(now.friction_work)
    assert min(lost) < -0.1


def test_slack_cable_that_becomes_taut_adds_no_energy() -> None:
    """A mass that falls into an elastic cable rebounds to decreasing heights."""
    robot, _ = corners()
    stiff = CableModel(
        "elastic_cable", (("stiffness", 2e4), ("damping", 0.0), ("longest_rest_length", 5.0))
    )
    muscle = replace(robot.muscles[0], model=stiff, friction=0.02)
    plant = Plant(replace(robot.with_muscles([muscle]), gravity=(9.81, 0.0, 0.0)), 2e-4)
    plant.reset([0.5], [0.0])
    rest, highest, tops = plant.muscle_lengths[0] + 0.1, 0.5, [0.5]
    for _ in range(8000):
        before, speed = plant.q[0], plant.qd[0]
        plant.step([rest])
        highest = min(highest, plant.q[0])
        if speed < 0 <= plant.qd[0] and plant.tensions[0] == 0.0:
            tops.append(before)
    assert len(tops) > 3
    assert highest == 0.5
    assert (np.diff(tops) > 0).all()


def test_long_steps_are_stable() -> None:
    """A light mass reverses within a step, for which an explicit rule is unstable."""
    robot, theta = corners()
    links = tuple(replace(k, inertia=Inertia(1e-4, (0, 0, 0), 1, 1, 1)) for k in robot.links)
    light = replace(robot, links=links, gravity=(F / 1e-4, 0.0, 0.0))  # the cable sticks
    plant = Plant(light, STEP)
    plant.reset([1.0], [3.0])
    for _ in range(200):
        plant.step([F])
    assert abs(plant.qd[0]) < 1e-9
    assert MU * theta > 0
    assert plant.far_tensions[0] == pytest.approx(F, rel=1e-6)


def test_dart_converges_to_the_core() -> None:
    """The difference decreases with the step, since DART uses the friction at its beginning."""
    off = []
    for step in (1e-3, 2.5e-4):
        plants = [Plant(corners()[0], step, engine=engine) for engine in ("core", "dart")]
        for plant in plants:
            plant.reset([1.0], [0.5])
            for k in range(round(0.4 / step)):
                plant.step([F + 5 * math.sin(20 * k * step)])
        off.append(abs(plants[0].q[0] - plants[1].q[0]))
    assert off[0] < 3e-3
    assert off[1] < 0.4 * off[0]


def test_series_elastic_motor_pulls_at_the_driven_end() -> None:
    """The cable after the spring is inextensible."""
    robot, theta = corners()
    model = PRESETS["roboy_test_bench"]
    plant = Plant(robot.with_muscles([replace(robot.muscles[0], model=model)]), STEP)
    plant.reset([1.0], commands=[12.0])
    state = plant.get_state()
    state[6:8] = 1.0
    plant.set_state(state)
    plant.hold([12.0])
    given = law_parameters(model)
    k, l0, r = (given[name] for name in ("stiffness", "rest_length", "spindle_radius"))
    tension = k * (plant.muscle_lengths[0] - l0 + r * state[5])
    assert tension > 1.0
    assert plant.tensions[0] == pytest.approx(tension, rel=1e-12)
    assert plant.far_tensions[0] == pytest.approx(tension * math.exp(MU * theta), rel=1e-12)


def test_unsupported_friction_is_rejected() -> None:
    """Check an unsupported integrator and an unsupported muscle law."""
    robot, _ = corners()
    with pytest.raises(InputError, match="rk4 does not support cable friction"):
        Plant(robot, integrator="rk4")
    spring = CableModel("passive_spring", (("K", 1.0),))
    muscle = replace(robot.muscles[0], model=spring, f_max=0.0)
    with pytest.raises(CardsflowError, match="passive_spring"):
        Plant(robot.with_muscles([muscle]))
