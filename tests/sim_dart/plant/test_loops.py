"""Closed loops compared with reduced equations, conservation laws, and convex optimisation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.robots.loops import (
    four_bar,
    four_bar_angles,
    random_loops,
    slider_crank,
    with_loop,
)

from addin_sdfusion.robot import InputError, Pose, Robot, UnknownNameError, read_robot
from cardsflow_fmu.results.analysis.drive_check import check as check_all
from sim_dart import CoreDynamics, Plant, close_loops
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native

BARS = (0.2, 0.5, 0.4, 0.5)
CRANK, ROD = 0.2, 0.5
Places = Callable[[float], FloatArray]


def four_bar_places(crank: float) -> FloatArray:
    """Return mass-weighted positions: x, z and scaled angle of each bar, times sqrt(mass)."""
    a, b, c, d = BARS
    angles = (crank, *four_bar_angles(BARS, crank))
    joint = a * np.array([np.cos(crank), np.sin(crank)])
    begins = (np.zeros(2), joint, np.array([d, 0.0]))
    return np.concatenate(
        [
            bar_places(at, angle, bar)
            for at, angle, bar in zip(begins, angles, (a, b, c), strict=True)
        ]
    )


def bar_places(at: FloatArray, angle: float, length: float) -> FloatArray:
    middle = at + 0.5 * length * np.array([np.cos(angle), np.sin(angle)])
    return np.sqrt(length) * np.array([*middle, length / np.sqrt(12.0) * angle])


def slider_places(crank: float) -> FloatArray:
    swing = -np.arcsin(CRANK * np.sin(crank) / ROD)
    joint = CRANK * np.array([np.cos(crank), np.sin(crank)])
    slide = joint[0] + ROD * np.cos(swing)
    bars = bar_places(np.zeros(2), crank, CRANK), bar_places(joint, swing, ROD)
    return np.concatenate([*bars, np.sqrt(0.3) * np.array([slide, 0.0, 0.0])])


def derivative(f: Callable[[float], FloatArray], x: float, e: float = 2e-3) -> FloatArray:
    """Return the derivative by differences of sixth order."""
    ends = [f(x + k * e) - f(x - k * e) for k in (1, 2, 3)]
    return np.asarray((45 * ends[0] - 9 * ends[1] + ends[2]) / (60 * e))


def swing(places: Places, masses: FloatArray, start: float, end: float) -> float:
    """Solve m(x) x'' + m'(x) x'^2 / 2 + V'(x) = 0 for a crank that starts at rest."""

    def mass(x: float) -> FloatArray:
        return np.sum(derivative(places, x) ** 2, keepdims=True)

    def weight(x: float) -> FloatArray:
        return np.array([9.81 * np.sqrt(masses) @ places(x)[1::3]])

    def rates(_: float, s: FloatArray) -> list[float]:
        x, v = s
        fall = derivative(weight, x) + 0.5 * derivative(mass, x) * v * v
        return [v, float(-fall[0] / mass(x)[0])]

    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
    found = solve_ivp(rates, (0.0, end), [start, 0.0], **options)  # type: ignore[call-overload]
    return float(found.y[0, -1])


MECHANISMS = {
    "four-bar": (four_bar(BARS), four_bar_places, np.array(BARS[:3])),
    "slider-crank": (slider_crank(CRANK, ROD), slider_places, np.array([CRANK, ROD, 0.3])),
}
mechanisms = pytest.mark.parametrize("name", MECHANISMS)


def gap(plant: Plant) -> float:
    core = plant._mechanism.core
    core.closures(core.handle, plant.qd.tobytes())
    return float(np.abs(core.array("closure_gap", 5)).max())


def swung_plant(robot: Robot, step: float, end: float, rule: str = "euler") -> tuple[Plant, float]:
    """Return the plant after a swing, and the largest gap during the swing."""
    plant = Plant(robot, step, integrator=rule, energy=True)  # type: ignore[arg-type]
    worst = 0.0
    for _ in range(round(end / step)):
        plant.step(np.zeros(len(robot.muscles)))
        worst = max(worst, gap(plant))
    return plant, worst


@pytest.mark.slow
@mechanisms
def test_loop_gap_of_euler_has_second_order(name: str) -> None:
    robot, *_ = MECHANISMS[name]
    coarse, fine = (swung_plant(robot, step, 1.0)[1] for step in (1e-3, 1e-4))
    assert coarse <= 1e-4
    assert fine == pytest.approx(0.01 * coarse, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_rk4_equals_reduced_equation_of_motion(name: str) -> None:
    robot, places, masses = MECHANISMS[name]
    expected = swing(places, masses, 1.0, 1.0)
    plant, worst = swung_plant(robot, 1e-3, 1.0, "rk4")
    assert plant.q[0] == pytest.approx(-expected, abs=1e-7)
    assert worst <= 1e-12
    coarse = swung_plant(robot, 4e-3, 1.0, "rk4")[0].q[0]
    assert abs(coarse + expected) <= 1e-4


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", MECHANISMS)
def test_euler_converges_with_first_order(name: str) -> None:
    robot, places, masses = MECHANISMS[name]
    expected = -swing(places, masses, 1.0, 1.0)
    errors = [swung_plant(robot, step, 1.0)[0].q[0] - expected for step in (1e-3, 5e-4)]
    assert errors[0] == pytest.approx(2.0 * errors[1], rel=0.1)


def test_energy_and_loops_are_conserved_for_ten_seconds() -> None:
    plant, worst = swung_plant(four_bar(), 2e-3, 10.0, "rk4")
    start = Plant(four_bar(), energy=True).energy
    energy = plant.energy
    assert worst <= 1e-12
    assert energy.kinetic + energy.potential == pytest.approx(start.potential, abs=1e-5)


def test_parallelogram_keeps_its_branch_in_singular_poses() -> None:
    """A rotating crank passes a singular pose in every half turn."""
    sides = (0.2, 0.5, 0.2, 0.5)
    robot = replace(four_bar(sides), gravity=(0.0, 0.0, 0.0))
    plant = Plant(robot)
    plant.reset(qd=[10.0, -10.0, 10.0])
    for _ in range(4000):
        plant.step([0.0, 0.0])
        assert abs(plant.q[0] + plant.q[1]) <= 1e-2  # the coupler remains horizontal
    assert plant.q[0] - robot.coordinates[0].initial > 30.0


@pytest.mark.slow
@pytest.mark.parametrize("robot", [four_bar(BARS), slider_crank()], ids=["four-bar", "slider"])
def test_loop_is_closed_at_any_crank_angle(robot: Robot) -> None:
    drawn = np.array([c.initial for c in robot.coordinates])
    turning = drawn
    for angle in np.linspace(-np.pi, np.pi, 37):
        q = close_loops(robot, [angle, *drawn[1:]], ["crank"])
        turning = close_loops(robot, [angle, *turning[1:]], ["crank"])
        for pose in (q, turning):
            assert pose[0] == angle
            assert (close_loops(robot, pose) == pose).all()


@pytest.mark.slow
def test_loops_are_closed_from_random_poses() -> None:
    robot, rng = four_bar(BARS), np.random.default_rng(0)
    for _ in range(100):
        close_loops(robot, rng.uniform(-3.0, 3.0, 3))


def test_fixed_loop_is_not_closed_with_reversed_orientation() -> None:
    robot = with_loop(four_bar(), type="ball", axes=())
    angle = float(np.sum(close_loops(robot)[:2]) - close_loops(robot)[2])
    end = Pose((0.4, 0.0, 0.0), (0.0, angle, 0.0))
    fixed = with_loop(four_bar(), type="fixed", axes=(), T_child_joint=end)
    drawn = np.array([c.initial for c in fixed.coordinates])
    q = close_loops(fixed, drawn + np.array([0.3, -0.3, 3.0]))
    dynamics = CoreDynamics(fixed)
    assert np.cos(q[0] + q[1] - q[2] - angle) == pytest.approx(1.0)
    assert np.linalg.matrix_rank(dynamics.loop_jacobian(q), tol=1e-6) == 3


def test_loop_that_cannot_be_closed_is_named_with_its_gap() -> None:
    robot = with_loop(four_bar(), T_child_joint=Pose((5.0, 0.0, 0.0)))
    with pytest.raises(InputError, match=r"joint 'closing': its loop cannot be closed; .* 3\.8 m"):
        Plant(robot)
    with pytest.raises(UnknownNameError):
        close_loops(four_bar(), hold=["nothing"])


def test_reset_closes_the_loops() -> None:
    plant = Plant(four_bar())
    plant.reset([-1.3, 0.5, -2.0], [1.0, 0.0, 0.0])
    assert gap(plant) <= 1e-10
    J = CoreDynamics(plant.robot).loop_jacobian(plant.q)
    assert np.abs(J @ plant.qd).max() <= 1e-12
    assert np.abs(plant.qd).max() > 0.1


def test_other_engines_are_rejected() -> None:
    with pytest.raises(
        InputError, match="joint 'closing': closes a loop, which only the engine \"core\""
    ):
        Plant(four_bar(), engine="dart")


def test_published_cycling_legs_are_simulated(shared: Path) -> None:
    """Six of the twelve loop equations are redundant, and limits are reached."""
    robot = read_robot(shared / "robots/cardsflow/biking_legs", repair=True)
    plant = Plant(robot)
    for _ in range(500):
        plant.step(np.zeros(12))
        core = plant._mechanism.core
        core.closures(core.handle, plant.qd.tobytes())
        assert np.abs(core.array("closure_gap", 12)).max() <= 2e-5
    J = CoreDynamics(robot).loop_jacobian(plant.q)
    assert np.linalg.matrix_rank(J, tol=1e-6) == 6
    assert np.abs(J @ plant.qd).max() <= 1e-5


STEP = 1e-3


def least_constraint(
    M: FloatArray,
    v0: FloatArray,
    J: FloatArray,
    grip: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> FloatArray:
    """Minimise 1/2 (v - v0)' M (v - v0) + sum grip |v| with J v = 0 and bounds."""
    import qpsolvers

    n = len(v0)
    eye, none = np.eye(n), np.zeros((n, n))
    P = np.block([[M, none], [none, 1e-12 * eye]])
    G = np.block([[eye, -eye], [-eye, -eye]])
    N = np.linalg.qr(J.T)[0].T if len(J) else J
    problem = qpsolvers.Problem(
        P,
        np.concatenate([-M @ v0, grip]),
        G,
        np.zeros(2 * n),
        np.hstack([N, np.zeros_like(N)]),
        np.zeros(len(N)),
        np.concatenate([low, np.zeros(n)]),
        np.concatenate([high, np.full(n, np.inf)]),
    )
    solution = qpsolvers.solve_problem(problem, "daqp")
    assert solution.x is not None
    return np.asarray(solution.x[:n])


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 60, 20))
def test_friction_limits_and_loops_are_solved_together(first: int) -> None:
    moved = 0
    for seed in range(first, first + 20):
        robot, q = random_loops(seed)
        rng = np.random.default_rng(seed)
        M = CoreDynamics(robot).mass_matrix(q)
        J = CoreDynamics(robot).loop_jacobian(q)
        _, values, rows = np.linalg.svd(J)
        J = rows[: (values > 1e-8).sum()]
        free = Plant(replace(robot, loops=()), STEP)
        v = rng.normal(size=len(q))
        v = v - J.T @ (J @ v)
        free.reset(q, v)
        f = rng.uniform(0.0, 30.0, len(robot.muscles))
        free.step(f)
        scale = np.abs(M @ v).max()
        grip = scale * rng.uniform(0.0, 1.0, len(q)) * (rng.uniform(size=len(q)) < 0.6)
        low = np.where(rng.uniform(size=len(q)) < 0.3, -0.2, -np.inf)
        high = np.where(rng.uniform(size=len(q)) < 0.3, 0.3, np.inf)
        changed = with_friction_and_limits(robot, q, grip / STEP, low, high)
        plant = Plant(changed, STEP)
        plant.reset(q, v)
        plant.step(f)
        expected = least_constraint(M, free.qd, J, grip, low, high)

        found, best = (
            0.5 * (x - free.qd) @ M @ (x - free.qd) + grip @ np.abs(x) for x in (plant.qd, expected)
        )
        assert found <= best + 1e-9 * max(1.0, best), seed
        assert np.abs(J @ plant.qd).max(initial=0.0) <= 1e-8, seed  # tolerance of stops
        assert (np.clip(plant.qd, low - 1e-8, high + 1e-8) == plant.qd).all(), seed
        moved += bool(np.abs(expected).max() > 0.05)
    assert moved > 3


def with_friction_and_limits(
    robot: Robot, q: FloatArray, friction: FloatArray, low: FloatArray, high: FloatArray
) -> Robot:
    """Return the robot with friction, and limits that allow such velocities."""
    changes = {
        c.name: {"friction": f, "lower": a + STEP * x, "upper": a + STEP * y, "initial": a}
        for c, a, f, x, y in zip(robot.coordinates, q, friction, low, high, strict=True)
    }
    joints = (
        replace(joint, coordinates=tuple(replace(c, **changes[c.name]) for c in joint.coordinates))
        for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


@pytest.mark.parametrize("offset", [4.5e-8, 9e-7])
def test_planes_of_a_loop_may_differ_by_the_rounding_of_a_file(offset: float) -> None:
    """No motion closes this gap; the motion is that of the exact linkage."""
    apart = with_loop(four_bar(), T_child_joint=Pose((0.4, offset, 0.0)))
    (finding,) = [f for f in check_all(apart) if f.code == "loops-not-exact"]
    assert f"stay open by {offset:.2g} m" in finding.message
    plants = [Plant(four_bar()), Plant(apart)]
    for plant in plants:
        plant.reset()
        for _ in range(500):
            plant.step([5.0, 5.0])
    np.testing.assert_allclose(plants[1].q, plants[0].q, rtol=0, atol=1e-11)
    further = with_loop(four_bar(), T_child_joint=Pose((0.4, 2e-6, 0.0)))
    with pytest.raises(InputError, match="the remaining gap is 2e-06 m"):
        close_loops(further)
