"""Cables with distributed elasticity and friction at bends: spans, drums, motion and energy."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.robots.muscle_bench import state_rates
from support.robots.one_link import one_link
from support.robots.random_robots import random_tree
from support.robots.wrapped import base_pulley

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    Inertia,
    Muscle,
    Pose,
    Robot,
    ViaPoint,
    Wrap,
    WrapSurface,
    prismatic,
)
from sim_dart import MuscleDrive, Plant
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.laws import MuscleLaws
from sim_dart.muscles.paths import MusclePaths

MU = 0.15
WINCH = {
    "drum_radius": 0.02,
    "gear_ratio": 10.0,
    "motor_inertia": 1e-5,
    "axial_stiffness": 2e4,
    "max_torque": 10.0,
    "lead_length": 0.3,
    "rest_length": 2.0,
}


def elastic(stiffness: float = 4e3) -> CableModel:
    values = {"stiffness": stiffness, "damping": 0.0, "longest_rest_length": 9.0}
    return CableModel("elastic_cable", tuple(values.items()))


def path_spring(stiffness: float, rest: float) -> CableModel:
    values = {"stiffness": stiffness, "rest_length": rest, "dissipation": 0.0}
    return CableModel("path_spring", tuple(values.items()))


def slider(
    *points: tuple[float, float, float], mass: float = 1e12, model: CableModel, **more: Any
) -> Robot:
    """Return a mass on a rail along x, which a cable pulls through points of the world."""
    given = {"friction": MU, "model": model} | more
    surfaces = given.pop("surfaces", ())
    path = (*(ViaPoint(WORLD, p) for p in points), ViaPoint("a", (0.0, 0.0, 0.0)))
    muscle = Muscle("m", path, 0.0, 1e4, **given)
    inertia = Inertia(mass, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0)
    robot = one_link(inertia, [muscle], surfaces, prismatic((1.0, 0.0, 0.0)), initial=1.0)
    return replace(robot, gravity=(0.0, 0.0, 0.0))


CORNERS = ((0.5, -0.5, 0.0), (-0.1, 0.1, 0.0), (-0.2, 0.0, 0.0))
SPANS = np.array([math.hypot(0.6, 0.6), math.hypot(0.1, 0.1), 1.2])
GRIPS = np.array([math.pi / 2, 3 * math.pi / 4]) * MU


def around_a_corner(model: CableModel) -> tuple[Robot, FloatArray, FloatArray]:
    """Return a cable over a quarter of a circle of 0.4 m, with half of the arc before its bend."""
    surface = WrapSurface("round", WORLD, "cylinder", 0.4, Pose((0.4, -0.4, 0.0)))
    wraps = (Wrap("round", 0, 0),)
    robot = slider((0.0, -0.6, 0.0), model=model, wraps=wraps, surfaces=(surface,))
    arc = 0.4 * math.pi / 2
    return robot, np.array([0.2 + arc / 2, 0.6 + arc / 2]), np.array([MU * math.pi / 2])


def over_a_pulley(model: CableModel) -> tuple[Robot, FloatArray, FloatArray]:
    """Return a cable over a pulley of 0.1 m at the base."""
    pulley = base_pulley(0.1, (0.0, -1.0, 0.0))
    robot, arc = slider((-0.1, 0.1, 0.0), model=model, pulley=pulley), 0.1 * math.pi / 2
    return robot, np.array([arc / 2, 1.0 + arc / 2]), np.array([MU * math.pi / 2])


SHAPES = {
    "corners": lambda model: (slider(*CORNERS, model=model), SPANS, GRIPS),
    "cylinder": around_a_corner,
    "pulley": over_a_pulley,
}


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("shape", SHAPES)
def test_mean_tension_of_sliding_cable_equals_its_stretch(shape: str, way: float) -> None:
    """Span tensions have capstan ratios, and the sum of l_i T_i / EA equals the stretch."""
    robot, spans, grips = SHAPES[shape](elastic(4e3))
    plant = Plant(robot, 1e-3)
    state = plant.get_state()
    count = len(plant.muscle_state_names)
    assert plant.muscle_state_names == tuple(
        f"{what}_{k + 1}.m" for what in ("stretch", "slip") for k in range(grips.size)
    )
    state[3 + count // 2 : 3 + count] = way
    plant.set_state(state)
    plant.hold([spans.sum() - 0.02])
    ratios = np.exp(np.concatenate([[0.0], np.cumsum(way * grips)]))
    first = 4e3 * 0.02 / (ratios @ spans / spans.sum())
    assert plant.tensions[0] == pytest.approx(first, rel=1e-12)
    assert plant.far_tensions[0] == pytest.approx(first * ratios[-1], rel=1e-12)


def stick_slip_stretch(stretch: FloatArray, compliance: FloatArray) -> FloatArray:
    """Return the stretch of spans with the smallest slip that satisfies the capstan ratios."""
    ratios = np.exp(GRIPS)
    while True:
        tension = stretch / compliance
        near, far = np.maximum(tension[:-1], tension[1:]), np.minimum(tension[:-1], tension[1:])
        over = near - far * ratios
        k = int(np.argmax(over))
        if over[k] <= 1e-12 * near[k]:
            return stretch
        more, less = (k, k + 1) if tension[k] > tension[k + 1] else (k + 1, k)
        slip = over[k] / (1 / compliance[more] + ratios[k] / compliance[less])
        stretch[more] -= slip
        stretch[less] += slip


def test_spans_stick_and_slide_while_winding() -> None:
    """Compare with separate spans for a small presliding displacement."""
    K = 4e3
    plant = Plant(slider(*CORNERS, model=elastic(K), presliding=1e-7), 1e-3)
    length, compliance = SPANS.sum(), SPANS / SPANS.sum() / K
    stretch, last = np.zeros(3), 0.0
    ways = [np.linspace(a, b, 501) for a, b in ((0, 0.05), (0.05, 0.03), (0.03, 0.05))]
    off = []
    for over in np.concatenate(ways):
        stretch[0] += over - last
        last = over
        stretch = stick_slip_stretch(stretch, compliance)
        plant.step([length - over])
        found = np.array([plant.tensions[0], plant.far_tensions[0]])
        off.append(found - stretch[[0, 2]] / compliance[[0, 2]])
    assert np.abs(off).max() < 2e-3 * 280.0  # delayed by one step
    assert np.abs(off)[500::501].max() < 1e-6 * 280.0  # all bends have slipped


def reference_motion(mass: float, K: float, force: float, duration: float, h: float) -> float:
    """Return the slider position with separate stretch of spans and without presliding."""
    q, v, stretch = 1.0, 0.0, SPANS / SPANS.sum() * 0.2
    for _ in range(round(duration / h)):
        spans = SPANS + np.array([0.0, 0.0, q - 1.0])
        compliance = spans / spans.sum() / K
        v += h * (force - stretch[2] / compliance[2]) / mass
        q += h * v
        stretch[2] += h * v
        stretch = stick_slip_stretch(stretch, compliance)
    return q


def test_mass_on_cable_moves_like_on_separate_springs() -> None:
    """Check stick and slip of a mass on a cable with a fixed end; the error has first order."""
    mass, K, force, duration = 2.0, 400.0, 40.0, 0.3
    exact = reference_motion(mass, K, force, duration, 2e-4)
    assert abs(exact - reference_motion(mass, K, force, duration, 4e-4)) < 1e-4
    robot = slider(*CORNERS, mass=mass, model=path_spring(K, SPANS.sum() - 0.2), presliding=1e-6)
    off = []
    for h in (1e-3, 2.5e-4):
        plant = Plant(replace(robot, gravity=(force / mass, 0.0, 0.0)), h)
        for _ in range(round(duration / h)):
            plant.step([0.0])
        off.append(abs(plant.q[0] - exact))
    assert off[0] < 1e-3
    assert off[1] < 0.3 * off[0]


@pytest.mark.parametrize("seed", [1, 14, 16, 20])
def test_springs_over_bends_dissipate_energy(seed: int) -> None:
    """The energy of trees on springs never exceeds its initial value and decreases."""
    rng, robot = np.random.default_rng(seed), random_tree(seed)
    q = rng.uniform(-1, 1, len(robot.coordinates))
    lengths = MusclePaths(robot).evaluate(q).lengths.copy()
    K, rest = 10 ** rng.uniform(2, 3, lengths.size), 0.95 * lengths
    springs = [
        replace(m, f_max=0.0, friction=0.3, presliding=1e-5, model=path_spring(*given))
        for m, given in zip(robot.muscles, np.column_stack([K, rest]).tolist(), strict=True)
    ]
    joints = tuple(
        replace(j, coordinates=tuple(replace(c, damping=0.0) for c in j.coordinates))
        for j in robot.joints
    )
    free = replace(robot.with_muscles(springs), gravity=(0.0, 0.0, 0.0), joints=joints)
    plant = Plant(free, 1e-4, energy=True)
    plant.reset(q, rng.normal(size=q.size))

    def energy() -> float:
        over = np.maximum(plant.muscle_lengths - rest, 0.0)
        return plant.energy.kinetic + plant.energy.potential + 0.5 * float(K @ over**2)

    begin, most = energy(), 0.0
    for _ in range(3000):
        plant.step(np.zeros(K.size))
        most = max(most, energy())
    assert most < begin * (1 + 1e-4)
    assert energy() < 0.95 * begin


def test_work_balance_is_closed() -> None:
    """Work of the cable minus friction losses equals kinetic energy for any commands."""
    rng = np.random.default_rng(2)
    plant = Plant(slider(*CORNERS, mass=2.0, model=elastic(2e3)), 1e-3, energy=True)
    for _ in range(300):
        if not 0.2 < plant.q[0] < 3:
            plant.reset([1.0], [rng.normal()])
        start = plant.energy
        plant.step([SPANS.sum() + rng.normal() * 0.1])
        now = plant.energy
        work = sum(now[2:]) - sum(start[2:])
        assert now.kinetic - start.kinetic == pytest.approx(work, abs=1e-12)
        assert now.friction_work <= start.friction_work
    assert now.friction_work < 0


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_drum_has_the_tension_of_the_first_span(way: float) -> None:
    """Compare with J w' = N u - r (T_1 + T_1^2 / 2 EA)."""
    model = CableModel("winch", tuple(WINCH.items()))
    paths = MusclePaths(slider(*CORNERS, model=model))
    laws = MuscleLaws(slider(*CORNERS, model=model), paths.core)
    paths.evaluate([1.0])
    torque = 0.2
    laws.start([torque])
    laws.states[-2:] = way
    T = laws.drive([0.0], [torque])[0]
    ratios = np.exp(np.concatenate([[0.0], np.cumsum(way * GRIPS)]))
    along = np.append(SPANS, WINCH["lead_length"]) / (SPANS.sum() + WINCH["lead_length"])
    mean = 2e4 * (math.sqrt(1 + 2 * torque * 10 / 0.02 / 2e4) - 1)  # tension without friction
    assert mean / T == pytest.approx(along @ np.append(ratios, 1.0), rel=1e-12)
    pull = T + T**2 / 2 / 2e4
    slow = state_rates(paths.core, [torque])[0]
    assert slow * 10.0**2 * 1e-5 == pytest.approx(torque * 10 - 0.02 * pull, rel=1e-9)


def test_commands_account_for_slip() -> None:
    """Compare the unstretched cable length for a tension of the first span."""
    drive = MuscleDrive(slider(*CORNERS, model=elastic()))
    for slips in ((), (0.6, -0.3), (1.0, 1.0)):
        drive.set_state([1.0], [0.0], [], slips)
        assert drive.tensions(np.array([2.15]))[0] > 0
        commands = drive.commands(np.array([70.0]), 1e-3)
        assert drive.tensions(commands)[0] == pytest.approx(70.0, rel=1e-12)


def test_dart_converges_to_the_core() -> None:
    off = []
    for step in (1e-3, 2.5e-4):
        robot = slider(*CORNERS, mass=2.0, model=elastic(500.0), presliding=1e-3)
        plants = [Plant(robot, step, engine=engine) for engine in ("core", "dart")]
        for plant in plants:
            plant.reset([1.0], [0.5])
            for k in range(round(0.3 / step)):
                plant.step([SPANS.sum() - 0.1 + 0.05 * math.sin(20 * k * step)])
        off.append(abs(plants[0].q[0] - plants[1].q[0]))
    assert off[0] < 3e-3
    assert off[1] < 0.4 * off[0]


@pytest.mark.parametrize("stiffness", [1e-7, 1.0, 1e9])
def test_extreme_parameters_give_finite_results(stiffness: float) -> None:
    """Check very short spans, very low and high stiffness, and random commands."""
    rng = np.random.default_rng(3)
    path = ((-0.1, 0.1 + 1e-9, 0.0), *CORNERS[1:], (-0.2, 1e-9, 0.0))
    robot = slider(*path, model=elastic(stiffness), friction=2.0, presliding=1e-9)
    plant = Plant(robot, 1e-3)
    for _ in range(200):
        plant.step([rng.uniform(0.0, 4.0)])
        slips = plant.get_state()[3 + 3 : 3 + 6]
        assert np.isfinite(plant.get_state()).all()
        assert np.abs(slips).max() <= 1 + 1e-12
