"""Semi-implicit Euler and Runge-Kutta 4 compared with closed forms, DOP853 and MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.cases import LONG
from support.oracles.mujoco_model import MujocoRobot
from support.robots.plants import steps
from support.robots.random_robots import random_robot
from support.robots.robots import EXAMPLES, one_joint, planar_2r, with_coordinates

from addin_sdfusion.robot import (
    WORLD,
    Coordinate,
    Inertia,
    InputError,
    Joint,
    Link,
    Robot,
    prismatic,
    read_robot,
    revolute,
)
from addin_sdfusion.robot.model.muscle import CableModel
from sim_dart import DartDynamics, Plant, Scene

SPAN, HELD = 8.0, 0.01
DRIVEN = (0.05, 0.1)


def elastic(robot: Robot, stiffness: float) -> Robot:
    model = CableModel("elastic_cable", (("stiffness", stiffness),))
    return robot.with_muscles([replace(muscle, model=model) for muscle in robot.muscles])


def slender(robot: Robot) -> Robot:
    """Return links with moments of inertia about all axes, which MuJoCo requires."""
    links = [replace(link, inertia=replace(link.inertia, iyy=0.1 / 12.0)) for link in robot.links]
    return replace(robot, links=tuple(links))


def free(robot: Robot, damping: float = 0.0) -> Robot:
    return with_coordinates(robot, lower=-np.inf, upper=np.inf, damping=damping)


def flywheel(**coordinate: Any) -> Robot:
    """Return a wheel of 0.5 kg·m² about a vertical axis."""
    wheel = Inertia(1.0, ixx=0.5, iyy=0.5, izz=0.5)
    return one_joint("turn", revolute((0.0, 0.0, 1.0)), wheel, **coordinate)


class Case:
    """Motion of a robot over 8 s, with rest lengths that are constant for 10 ms each.

    Args:
        robot: The robot.
        start: Initial positions at rest.
        shortening: Relative shortening of the cables and its amplitude.
        stiffness: Stiffness of the cables, in [N/m], or None.
    """

    def __init__(
        self,
        robot: Robot,
        start: Sequence[float],
        shortening: tuple[float, float] = (0.0, 0.0),
        stiffness: float | None = None,
    ) -> None:
        self.robot = robot if stiffness is None else elastic(robot, stiffness)
        self.dynamics = DartDynamics(self.robot)
        self.q = np.array(start)
        self.stiffness = stiffness
        self._mean, self._swing = shortening
        self._length = self.dynamics.muscle_lengths(start)
        self._phases = np.arange(len(self.robot.muscles))

    def commands(self, t: float) -> np.ndarray:
        if self.stiffness is None:
            return np.zeros(self._phases.size)
        held = HELD * np.floor(t / HELD + 1e-6)
        part = self._mean + self._swing * np.sin(2.0 * held + self._phases)
        return self._length * (1.0 - part)

    def rates(self, t: float, y: np.ndarray, u: np.ndarray) -> np.ndarray:
        n = self.q.size
        q, qd = y[:n], y[n:]
        d = self.dynamics
        tau = -d.damping * qd - d.coriolis(q, qd) - d.gravity(q)
        if self.stiffness is not None:
            f = np.maximum(self.stiffness * (d.muscle_lengths(q) - u), 0.0)
            tau = tau - d.muscle_jacobian(q).T @ f
        return np.concatenate([qd, np.linalg.solve(d.mass_matrix(q), tau)])

    @property
    def ticks(self) -> int:
        return round(SPAN / HELD)

    def reference(self, rtol: float = 1e-12) -> np.ndarray:
        """Return q from DOP853 every 10 ms."""
        y = np.concatenate([self.q, np.zeros_like(self.q)])
        rows = [self.q]
        for k in range(self.ticks):
            u = self.commands(k * HELD)
            solved = solve_ivp(
                self.rates, (0.0, HELD), y, "DOP853", args=(u,), rtol=rtol, atol=rtol
            )
            y = solved.y[:, -1]
            rows.append(y[: self.q.size])
        return np.array(rows)

    def way(self, step: float, integrator: Any = "euler") -> np.ndarray:
        """Return q from the plant every 10 ms."""
        plant = Plant(self.robot, step, integrator=integrator)
        plant.reset(self.q)
        rows = [plant.q]
        for k in range(self.ticks):
            u = self.commands(k * HELD)
            steps(plant, round(HELD / step), u)
            rows.append(plant.q)
        return np.array(rows)


CASES: dict[str, Callable[[], Case]] = {
    "hanging": lambda: Case(free(planar_2r()), (np.pi - 0.44, 0.0)),
    "hanging, cables that go slack": lambda: Case(
        free(planar_2r(), 0.05), (np.pi - 0.4, 0.2), stiffness=200.0
    ),
    "driven, damped": lambda: Case(free(planar_2r(), 1.0), (0.3, -0.4), DRIVEN, 200.0),
    "Roboy's arm, damped": lambda: Case(
        free(read_robot(EXAMPLES / "roboy_left_arm/robot"), 0.05),
        (1.45, 0.0, 0.0, -1.3),
        (0.05, 0.02),
        2000.0,
    ),
}


@cache
def case(name: str) -> tuple[Case, np.ndarray]:
    made = CASES[name]()
    return made, made.reference()


def largest_error(name: str, step: float, integrator: str = "euler") -> float:
    made, expected = case(name)
    return float(np.abs(made.way(step, integrator) - expected).max())


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_reference_is_not_chaotic(name: str) -> None:
    """Comparisons are not meaningful for chaotic motions."""
    made, expected = case(name)
    assert np.abs(made.reference(1e-10) - expected).max() < 1e-7


@pytest.mark.cases(2)
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("hanging, cables that go slack", 2e-3),
        ("hanging", 5e-3),
        ("driven, damped", 2e-3),
        ("Roboy's arm, damped", 2e-3),
    ],
)
def test_semi_implicit_euler_has_first_order(name: str, error: float) -> None:
    coarse, fine = largest_error(name, 1e-3), largest_error(name, 5e-4)
    assert coarse < error
    assert coarse / fine == pytest.approx(2.0, rel=0.1)


@pytest.mark.slow
def test_rk4_has_fourth_order_for_smooth_motions() -> None:
    errors = [largest_error("hanging", h, "rk4") for h in (1e-2, 5e-3, 2.5e-3)]
    assert errors[0] < 3e-5
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(16.0, rel=0.15)


@pytest.mark.parametrize(
    ("name", "gain"),
    [
        ("hanging", 1e5),
        ("hanging, cables that go slack", 1e3),
        pytest.param("driven, damped", 300.0, marks=[pytest.mark.slow, LONG]),
        pytest.param("Roboy's arm, damped", 1e3, marks=[pytest.mark.slow, LONG]),
    ],
)
def test_rk4_is_more_accurate_than_euler(name: str, gain: float) -> None:
    assert gain * largest_error(name, 1e-3, "rk4") < largest_error(name, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["driven, damped", "Roboy's arm, damped"])
def test_euler_errors_equal_mujoco(name: str) -> None:
    """MuJoCo and DART use the same semi-implicit rule with implicit damping."""
    made = CASES[name]()
    if name == "driven, damped":
        made = Case(slender(made.robot), made.q, DRIVEN, made.stiffness)
    oracle = MujocoRobot(made.robot)
    model, data = oracle.model, oracle.data
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    model.dof_damping[oracle._order] = made.dynamics.damping
    model.tendon_stiffness[:] = made.stiffness
    model.tendon_lengthspring[:, 0] = 0.0
    data.qpos[oracle._order] = made.q
    rows = [made.q]
    for k in range(made.ticks):
        model.tendon_lengthspring[:, 1] = made.commands(k * HELD)
        mujoco.mj_step(model, data, nstep=10)
        rows.append(data.qpos[oracle._order].copy())
    np.testing.assert_allclose(made.way(1e-3), np.array(rows), rtol=0, atol=1e-8)


def test_rk4_damping_equals_closed_form() -> None:
    """Compare with qd = exp(-d t / I) to the fifth power of the step."""
    d, h = 2.0, 0.01
    plant = Plant(flywheel(damping=d), h, integrator="rk4")
    plant.reset([0.0], [1.0])
    plant.step([])
    x = d * h / 0.5
    assert abs(plant.qd[0] - np.exp(-x)) == pytest.approx(x**5 / 120, rel=0.05)


@pytest.mark.parametrize(("integrator", "ratio"), [("euler", 2.0), ("rk4", 16.0)])
def test_joint_spring_oscillates(integrator: Any, ratio: float) -> None:
    """Compare with q = r + (q0 - r) cos(sqrt(K/I) t)."""
    errors = []
    for h in (0.02, 0.01):
        plant = Plant(flywheel(stiffness=3.0, rest=0.2), h, integrator=integrator)
        plant.reset([0.5])
        worst_yet = 0.0
        for _ in range(round(2.0 / h)):
            plant.step([])
            exact = 0.2 + 0.3 * np.cos(np.sqrt(3.0 / 0.5) * plant.time)
            worst_yet = max(worst_yet, abs(plant.q[0] - exact))
        errors.append(worst_yet)
    assert errors[0] / errors[1] == pytest.approx(ratio, rel=0.12)


def test_controller_model_includes_springs() -> None:
    dynamics = DartDynamics(flywheel(stiffness=3.0, rest=0.2))
    assert dynamics.gravity([0.5]) == pytest.approx([3.0 * 0.3], abs=1e-12)


def test_coulomb_friction_stops_and_holds_a_wheel() -> None:
    """The wheel stops after the time I w / F and angle w² I / 2F, and sticks."""
    robot = flywheel(friction=0.4, actuated=True)
    plant = Plant(robot, 1e-3)
    plant.reset([0.0], [1.0])
    steps(plant, 1000, [])
    assert plant.q[0] == pytest.approx(1.0 - 0.5 * 0.4 / 0.5, abs=1e-3)
    steps(plant, 500, [])
    assert plant.qd[0] == pytest.approx(0.0, abs=1e-12)
    assert plant.q[0] == pytest.approx(0.5 * 0.5 / 0.4, abs=1e-3)
    resting = plant.q[0]
    steps(plant, 200, [], [0.39])
    assert plant.q[0] == pytest.approx(resting, abs=1e-9)
    plant.step([], [0.6])
    assert plant.qd[0] == pytest.approx(1e-3 * 0.2 / 0.5, rel=1e-6)


@pytest.mark.parametrize("integrator", ["euler", "rk4"])
def test_substeps_are_shorter_steps(integrator: Any) -> None:
    made = CASES["driven, damped"]()
    fine = Plant(made.robot, 2.5e-4, integrator=integrator)
    coarse = Plant(made.robot, 1e-3, integrator=integrator, substeps=4)
    u = made.commands(0.0)
    for plant in (fine, coarse):
        plant.reset(made.q)
    for _ in range(50):
        coarse.step(u)
        steps(fine, 4, u)
    np.testing.assert_array_equal(coarse.q, fine.q)
    assert coarse.time == pytest.approx(fine.time, abs=1e-12)


@pytest.mark.parametrize(("integrator", "order"), [("euler", 1), ("rk4", 4)])
def test_error_of_energy_balance_has_the_order_of_the_integrator(
    integrator: Any, order: int
) -> None:
    """Kinetic and potential energy minus the work of muscles, loads and damping is constant."""
    robot = with_coordinates(free(planar_2r(), 0.2), stiffness=1.5, rest=0.3)
    left = []
    for h in (8e-3, 4e-3):
        plant = Plant(robot, h, integrator=integrator, energy=True)
        plant.reset([2.0, 0.5], [1.0, -1.0])
        start = total(plant)
        steps(plant, round(1.6 / h), [20.0, 5.0, 10.0, 8.0], loads=[0.5, 0.0, 0.3])
        assert plant.energy.damping_work < -0.1
        assert abs(plant.energy.outer_work) > 0.01
        left.append(abs(total(plant) - start))
    assert left[0] / left[1] > 0.7 * 2**order
    assert left[1] < (0.2 if order == 1 else 1e-4)


def total(plant: Plant) -> float:
    e = plant.energy
    return e.kinetic + e.potential - e.muscle_work - e.outer_work - e.damping_work


def floating(robot: Robot) -> Robot:
    """Return the robot on a heavy floating body without gravity."""
    axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    motions = (
        *(replace(prismatic(axis)[0], coordinate=k) for k, axis in enumerate(axes)),
        *(replace(revolute(axis)[0], coordinate=3 + k) for k, axis in enumerate(axes)),
    )
    names = [*(f"base_{k}" for k in "xyz"), *(f"base_{k}" for k in "abc")]
    coordinates = tuple(
        Coordinate(name, unit=motion.unit) for name, motion in zip(names, motions, strict=True)
    )
    base = Link("base", Inertia(3.0, (0.1, 0.0, 0.0), 0.1, 0.2, 0.3))
    joints = [replace(j, parent="base" if j.parent == WORLD else j.parent) for j in robot.joints]
    muscles = [
        replace(
            muscle,
            via_points=tuple(
                replace(p, link="base" if p.link == WORLD else p.link) for p in muscle.via_points
            ),
        )
        for muscle in robot.muscles
    ]
    free_joint = Joint("free", WORLD, "base", motions, coordinates)
    made = replace(
        robot,
        links=(base, *robot.links),
        joints=(free_joint, *joints),
        gravity=(0.0, 0.0, 0.0),
    )
    return made.with_muscles(muscles)


@pytest.mark.parametrize(("integrator", "kept"), [("euler", 0.05), ("rk4", 1e-7)])
def test_muscles_do_not_change_the_momentum_of_a_floating_robot(
    integrator: Any, kept: float
) -> None:
    robot = floating(random_robot(5, joints=3, muscles=4))
    plant = Plant(robot, 1e-3, integrator=integrator)
    rng = np.random.default_rng(5)
    plant.reset(rng.uniform(-0.3, 0.3, plant.q.size), rng.uniform(-0.5, 0.5, plant.q.size))
    before = plant.momentum
    steps(plant, 200, np.full(4, 2.0))
    after = plant.momentum
    assert np.linalg.norm(before.angular) > 0.1
    np.testing.assert_allclose(after.linear, before.linear, rtol=0, atol=kept)
    np.testing.assert_allclose(after.angular, before.angular, rtol=0, atol=kept)


def test_rk4_and_euler_stop_at_the_same_limits() -> None:
    robot = with_coordinates(planar_2r(), lower=-0.4, upper=0.4)
    ends = []
    for integrator in ("euler", "rk4"):
        plant = Plant(robot, 1e-3, integrator=integrator)  # type: ignore[arg-type]
        plant.reset([0.3, 0.1])
        for _ in range(1500):
            plant.step(np.zeros(4))
            assert np.all(np.abs(plant.q) <= 0.4 + 1e-9)
        ends.append(plant.q)
    np.testing.assert_allclose(ends[1], ends[0], atol=2e-3)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"engine": "dart"}, 'rk4 does not support the engine "dart"; use integrator = "euler"'),
        ({"scene": Scene()}, 'rk4 does not support worlds with contacts; use integrator = "euler"'),
    ],
)
def test_rk4_requires_the_core(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Plant(planar_2r(), integrator="rk4", **changed)


def test_invalid_settings_are_rejected() -> None:
    with pytest.raises(InputError, match="unknown integrator 'leapfrog'; known: euler, rk4"):
        Plant(planar_2r(), integrator="leapfrog")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="does not record its energy"):
        _ = Plant(planar_2r()).energy
