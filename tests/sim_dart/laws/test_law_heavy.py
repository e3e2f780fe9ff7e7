"""Heavy cables compared with the closed form of the elastic catenary."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from support.robots.muscle_bench import Bench
from support.robots.wrapped import FAR, carriage

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    CardsflowError,
    Muscle,
    Robot,
    ViaPoint,
    Wrap,
    check,
)
from sim_dart import CoreDynamics, Plant
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.laws import MuscleLaws

CLOSE = 1e-9


class Catenary(NamedTuple):
    """Hanging cable by Irvine's equations, defined by the force at its second end."""

    EA: float
    mass: float
    rest: float
    H: float
    V: float
    """Upward force at the second end. At the first end it is V minus the weight."""

    def span(self, g: float) -> tuple[float, float]:
        """Return the horizontal and vertical distance of both ends."""
        EA, w, L, H, V = map(np.longdouble, (self.EA, self.mass * g, self.rest, self.H, self.V))
        W = w * L
        far = H * L / EA + H / w * (np.arcsinh(V / H) - np.arcsinh((V - W) / H))
        high = L / EA * (V - W / 2) + (np.hypot(H, V) - np.hypot(H, V - W)) / w
        return float(far), float(high)


def _catenaries() -> list[Catenary]:
    rng = np.random.default_rng(2)
    found = []
    for _ in range(300):
        rest, mass = 10 ** rng.uniform(-0.5, 2.0), 10 ** rng.uniform(-2.5, 0.5)
        W = 9.81 * rest * mass
        H = W * 10 ** rng.uniform(-2.0, 3.0)
        V = rng.uniform(-2, 2) * max(H, W)
        EA = np.hypot(H, abs(V) + W) / 10 ** rng.uniform(-4, -0.5)
        if EA > 1e9:
            continue
        found.append(Catenary(EA, mass, rest, H, V))
    return found


def hanging_cable(cable: Catenary, gravity: FloatArray, *, turned: bool = False) -> Robot:
    """Return a robot with the cable from the world to a carriage, or in reverse order."""
    ends = (ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(FAR, (0.0, 0.0, 0.0)))
    parameters = (("axial_stiffness", cable.EA), ("mass_per_length", cable.mass))
    model = CableModel("heavy_cable", parameters)
    muscle = Muscle("m", ends[::-1] if turned else ends, 0.0, 1e9, model)
    return replace(carriage([muscle], []), gravity=tuple(gravity.tolist()))


class FixedEndCable:
    """Heavy cable with one end at a fixed position q."""

    def __init__(self, robot: Robot) -> None:
        self.core = Core(compile_blob(robot))
        self.laws = MuscleLaws(robot, self.core)

    def pull(self, q: FloatArray, rest: float) -> FloatArray:
        """Return the force on the carriage, shape (3,)."""
        self.core.move(self.core.handle, q.tobytes())
        self.laws.drive(np.zeros(3), [rest])
        return self.laws.torques.copy()


def test_forces_and_length_equal_the_elastic_catenary() -> None:
    """Check nearly straight cables up to a length of five chords, for any gravity direction."""
    rng = np.random.default_rng(4)
    slackest = 0.0
    for cable in _catenaries():
        down = rng.normal(size=3)
        down /= np.linalg.norm(down)
        along = np.cross(down, rng.normal(size=3))
        along /= np.linalg.norm(along)
        far, high = cable.span(9.81)
        q = far * along - high * down
        W, chord = 9.81 * cable.mass * cable.rest, float(np.hypot(far, high))
        if chord > 2 * cable.rest or chord < 0.1 * cable.rest:
            continue
        slackest = max(slackest, cable.rest / chord)
        largest = np.hypot(cable.H, max(abs(cable.V), abs(cable.V - W)))
        second = FixedEndCable(hanging_cable(cable, 9.81 * down))
        pull = second.pull(q, cable.rest)
        expected = -cable.H * along + cable.V * down  # the vertical force on the carriage is V
        assert np.abs(pull - expected).max() < CLOSE * largest
        f = float(second.laws.tensions[0])
        assert f == pytest.approx(cable.H * chord / far, rel=CLOSE)
        rest = float(second.laws.invert([f], 1e-3)[0])
        assert rest == pytest.approx(cable.rest, rel=CLOSE)
        first = FixedEndCable(hanging_cable(cable, 9.81 * down, turned=True))
        pull = first.pull(-q, cable.rest)  # now the first end is at the carriage
        expected = cable.H * along - (cable.V - W) * down
        # exchanging the ends does not change the shape
        same = second.pull(q, cable.rest)
        assert np.abs(first.pull(q, cable.rest) - same).max() < CLOSE * largest
        assert np.abs(pull - expected).max() < CLOSE * largest
    assert slackest > 3.0


def test_heavy_cable_without_weight_equals_elastic_cable() -> None:
    heavy = {"axial_stiffness": 1e4, "mass_per_length": 0.0, "damping": 20.0}
    bench = Bench(("heavy_cable", heavy))
    for length, speed, rest in ((0.5, 0.1, 0.49), (0.5, -0.2, 0.45), (0.5, 0.0, 0.6)):
        f = max(1e4 * (length / rest - 1), 0.0) + 20.0 * speed
        assert bench.tension(length, speed, rest) == pytest.approx(max(f, 0.0), rel=1e-12)
    cable = Catenary(1e4, 2.0, 1.0, 1.0, 1.0)
    held = FixedEndCable(hanging_cable(cable, np.zeros(3)))
    np.testing.assert_allclose(held.pull(np.array([1.02, 0, 0]), 1.0), [-200.0, 0, 0], rtol=1e-12)
    held = FixedEndCable(hanging_cable(cable._replace(mass=1e-9), np.array([0, 0, -9.81])))
    np.testing.assert_allclose(held.pull(np.array([1.02, 0, 0]), 1.0), [-200.0, 0, 0], atol=1e-6)


def test_cable_with_coincident_ends() -> None:
    """Without horizontal distance, each side carries a part of the weight, or the cable is taut."""
    cable = Catenary(1e5, 0.5, 3.0, 1.0, 1.0)
    held = FixedEndCable(hanging_cable(cable, np.array([0, 0, -10.0])))
    for rise in (0.0, 1.0, -1.0, 2.5):
        at = np.array([0.0, 0.0, rise])
        pull = held.pull(at, 3.0)
        # two sides, l_1 + l_2 = L and l_2 - l_1 = rise, plus the stretch by the weight
        stretch = 5.0 * (2 * 1.5**2) / 2 / 1e5
        assert pull[2] == pytest.approx(-5.0 * (3.0 + rise) / 2, abs=5.0 * stretch + 1e-3)
        assert np.abs(pull[:2]).max() < 1e-6
    pull = held.pull(np.array([0.0, 0.0, 3.03]), 3.0)
    assert pull[2] == pytest.approx(-(1e5 * 0.01 + 15.0 / 2), rel=1e-9)


def test_gravity_torque_includes_the_cable_weight() -> None:
    """Compare G with and without the weight of the cable, which controllers use."""
    cable, down = Catenary(1e6, 0.4, 5.0, 1.0, 1.0), np.array([0.0, 0.0, -9.81])
    robot = hanging_cable(cable, down)
    heavy = CoreDynamics(robot)
    light = CoreDynamics(hanging_cable(cable._replace(mass=0.0), down))
    q, rng = np.array([3.0, 0.5, 2.0]), np.random.default_rng(1)
    held = FixedEndCable(robot)
    chord = float(np.linalg.norm(q))
    pull = held.pull(q, chord)
    beside = pull + held.laws.tensions[0] * q / chord
    np.testing.assert_allclose(light.gravity(q) - heavy.gravity(q), beside, atol=1e-9)
    assert beside[2] == pytest.approx(-0.4 * 9.81 * chord / 2, rel=0.05)
    tau, rates = rng.normal(size=3), rng.normal(size=3)
    load = tau - heavy.coriolis(q, rates) - heavy.gravity(q)
    expected = np.linalg.solve(heavy.mass_matrix(q), load)
    np.testing.assert_allclose(heavy.acceleration(q, rates, tau), expected, rtol=1e-10)


def test_both_engines_compute_the_same_motion() -> None:
    robot = hanging_cable(Catenary(2e4, 0.8, 2.0, 1.0, 1.0), np.array([0.0, 0.0, -9.81]))
    plants = [Plant(robot, engine=e, step=5e-4) for e in ("core", "dart")]
    for plant in plants:
        plant.reset([1.5, 0.2, -1.0])
        for _ in range(200):
            plant.step([1.9])
    np.testing.assert_allclose(plants[0].q, plants[1].q, rtol=0, atol=1e-9)
    assert np.abs(plants[0].q - [1.5, 0.2, -1.0]).max() > 0.02


def test_unsupported_combinations_are_rejected() -> None:
    robot = hanging_cable(Catenary(1e4, 0.5, 2.0, 1.0, 1.0), np.array([0.0, 0.0, -9.81]))
    muscle = robot.muscles[0]
    ends = muscle.via_points
    between = (ends[0], ViaPoint(WORLD, (0.1, 0.0, 0.0)), ends[1])
    for changed, word in (
        (replace(muscle, via_points=between), "3 via points"),
        (replace(muscle, wraps=(Wrap("s", 0),)), "wraps"),
        (replace(muscle, friction=0.1), "friction"),
    ):
        findings = check(robot.with_muscles([changed]))
        found = [str(f) for f in findings if f.code == "heavy-cable-path"]
        assert len(found) == 1
        assert word in found[0]
    with pytest.raises(CardsflowError, match="hangs between two via points"):
        Core(compile_blob(robot.with_muscles([replace(muscle, via_points=between)])))
