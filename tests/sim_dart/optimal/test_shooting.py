"""Intervals of motions: their ends equal steps of the plant, their derivatives differences."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from support.robots.bent_cables import with_bent_cables
from support.robots.loops import five_bar
from support.robots.muscle_bench import SOUND, slider
from support.robots.robots import EXAMPLES, PLANAR_2R
from support.robots.wrapped import FAR, over_ellipsoids

from addin_sdfusion.robot import WORLD, CardsflowError, Robot, SimulationError, ViaPoint, Wrap
from cardsflow_fmu import Experiment
from sim_dart import Plant
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.optimal.shooting import Shooting

COUNT, H, STEPS = 20, 0.02, 2


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Experiment.load(PLANAR_2R).robot


def _arguments(shooting: Shooting) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    x = rng.uniform(-0.4, 0.4, (COUNT, shooting.nx))
    return x, rng.uniform(10.0, 60.0, (COUNT, shooting.nu)), np.full(COUNT, H)


def test_ends_equal_those_of_the_plant(robot: Robot) -> None:
    shooting = Shooting(robot, STEPS)
    x, u, h = _arguments(shooting)
    found = shooting.run(x, u, h)
    plain = shooting.run(x, u, h, derivatives=False)
    assert found is not None
    assert plain is not None
    np.testing.assert_allclose(found.ends, plain.ends, rtol=1e-13, atol=1e-13)
    plant = Plant(robot, step=H / STEPS, integrator="rk4")
    for start, forces, end in zip(x, u, plain.ends, strict=True):
        plant.reset(start[:2], start[2:])
        for _ in range(STEPS):
            plant.step(forces)
        np.testing.assert_allclose([*plant.q, *plant.qd], end, rtol=1e-13, atol=1e-13)


def _check_derivatives(shooting: Shooting, x: np.ndarray, u: np.ndarray, h: np.ndarray) -> None:
    """Compare the derivatives along one direction with differences."""
    e, rng = 1e-6, np.random.default_rng(1)
    found = shooting.run(x, u, h)
    assert found is not None
    dx, du = (rng.normal(size=own.shape) * np.maximum(abs(own), 0.1) for own in (x, u))
    dh = h * rng.normal(size=len(h))
    ends = [shooting.run(x + s * dx, u + s * du, h + s * dh, False) for s in (e, -e)]
    assert ends[0] is not None
    assert ends[1] is not None
    along = np.einsum("kij,kj->ki", found.A, dx) + np.einsum("kij,kj->ki", found.B, du)
    along += found.c * dh[:, None]
    np.testing.assert_allclose(along, (ends[0].ends - ends[1].ends) / (2 * e), rtol=2e-6, atol=2e-6)


@pytest.mark.parametrize("threads", [1, 3])
def test_derivatives_match_differences(robot: Robot, threads: int) -> None:
    shooting = Shooting(robot, STEPS, threads)
    _check_derivatives(shooting, *_arguments(shooting))


def test_results_do_not_depend_on_the_shares_of_threads() -> None:
    one, several = (Shooting(over_ellipsoids(), STEPS, threads) for threads in (1, 3))
    x, u, h = _arguments(one)
    for _ in range(3):
        found, expected = several.run(x, u, h), one.run(x, u, h)
        assert found is not None
        assert expected is not None
        for each, other in zip(found, expected, strict=True):
            np.testing.assert_array_equal(each, other)


def test_intervals_with_different_steps_equal_those_with_one_number(robot: Robot) -> None:
    shooting, steps = Shooting(robot), np.arange(COUNT) % 4 + 1
    x, u, h = _arguments(shooting)
    _check_derivatives(shooting, x, u, h)
    some = np.array([9, 2, 15])
    with shooting.using(steps):
        every, chosen = shooting.run(x, u, h), shooting.run(x[some], u[some], h[some], nodes=some)
        _check_derivatives(shooting, x, u, h)
    assert every is not None
    assert chosen is not None
    for k, number in enumerate(steps.tolist()):
        alone = Shooting(robot, number).run(x[k : k + 1], u[k : k + 1], h[k : k + 1])
        assert alone is not None
        for each, expected in zip(every, alone, strict=True):
            np.testing.assert_array_equal(each[k], expected[0])
    for each, expected in zip(chosen, every, strict=True):
        np.testing.assert_array_equal(each, expected[some])


@pytest.mark.parametrize("is_elastic", [0, 1])
def test_derivatives_with_muscle_laws_match_differences(is_elastic: int) -> None:
    """Commands, activations, also below their minimum, and fibre lengths of elastic muscles."""
    shooting = _hill_arm(is_elastic, **{"muscles.*.model.minimum_activation": 0.3})
    assert shooting.nx == 4 + 6 * (1 + is_elastic)
    rng = np.random.default_rng(2)
    x = rng.uniform(0.2, 0.8, (COUNT, shooting.nx))
    if is_elastic:
        x[:, 5::2] = [shooting.start(row[:2], row[4::2])[1::2] for row in x]
    _check_derivatives(shooting, x, rng.uniform(0.2, 0.8, (COUNT, 6)), np.full(COUNT, H))


def test_activations_below_their_minimum_tend_to_the_command() -> None:
    shooting = _hill_arm(0, **{"muscles.*.model.minimum_activation": 0.3})
    x = np.array([[0.3, 0.5, 0.0, 0.0, *np.full(6, 0.4)]])
    for _ in range(25):
        found = shooting.run(x, np.full((1, 6), 0.1), np.array([0.02]), False)
        assert found is not None
        x[:, 4:] = found.ends[:, 4:]
    np.testing.assert_allclose(x[0, 4:], 0.1, atol=1e-3)


@pytest.mark.parametrize(
    ("duration", "steps"), [(0.04, (2, 4, 8, 256)), (0.002, (32, 64, 128, 512))]
)
def test_fibres_with_elastic_tendons_have_order_three(
    duration: float, steps: tuple[int, ...]
) -> None:
    """Without damping, also in steps of 20 ms, where explicit ones diverge, and of 16 us."""
    shooting = _hill_arm(1, **{"muscles.*.model.fibre_damping": 0.0})
    q, u = np.array([0.3, 0.5]), np.full((1, 6), 0.3)
    x = np.array([[*q, 0.0, 0.0, *shooting.start(q, np.full(6, 0.1))]])
    ends = []
    for shooting.steps in steps:
        found = shooting.run(x, u, np.array([duration]), False)
        assert found is not None
        ends.append(found.ends)
    errors = [float(abs(own - ends[-1]).max()) for own in ends[:-1]]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (orders > 2.5).all(), errors


def _hill_arm(is_elastic: int, **settings: float) -> Shooting:
    own = {"muscles.*.model.elastic_tendon": is_elastic, **settings}
    return Shooting(Experiment.load(EXAMPLES / "hill_arm", own).robot, STEPS, with_laws=True)


@pytest.mark.parametrize("is_inside", [False, True])
def test_derivatives_over_ellipsoids_match_differences(is_inside: bool) -> None:
    """With an end inside, the ellipsoid changes with the pose."""
    robot = over_ellipsoids()
    if is_inside:
        inner = ViaPoint(WORLD, (0.0, 0.0, 0.05))
        ends = [replace(m, via_points=(inner, *m.via_points[1:])) for m in robot.muscles]
        robot = robot.with_muscles(ends)
    shooting = Shooting(robot, 1)
    _check_derivatives(shooting, *_arguments(shooting))


@pytest.mark.parametrize("rule", ["taut", "opensim"])
def test_derivatives_of_partly_rigid_paths_match_differences(
    rule: Literal["taut", "opensim"],
) -> None:
    """Each coordinate moves other parts of the path, over surfaces before and after it."""
    robot = over_ellipsoids()
    links, places = (
        (WORLD, "link_0", "link_1", FAR),
        ((-0.3, 0.02), (0.2, 0.05), (0.24, 0.04), (0.4, -0.03)),
    )
    points = tuple(ViaPoint(link, (*at, 0.02)) for link, at in zip(links, places, strict=True))
    wraps = Wrap("egg", 0, rule=rule), Wrap("far", 2, rule=rule)
    muscles = [replace(robot.muscles[0], via_points=points, wraps=wraps), *robot.muscles[1:]]
    shooting = Shooting(robot.with_muscles(muscles), 1)
    _check_derivatives(shooting, *_arguments(shooting))


def test_derivatives_of_every_muscle_law_match_differences() -> None:
    """Except those with dry friction, which has kinks."""
    smooth = {k: own for k, own in SOUND.items() if "winch" not in k and "motor" not in k}
    shooting = Shooting(slider(*smooth.items()), STEPS, with_laws=True)
    rng, count, q = np.random.default_rng(3), 4, np.array([0.305])
    low = np.maximum(shooting.laws.command_low[shooting.driven], -1.0)
    high = np.minimum(shooting.laws.command_high[shooting.driven], 1.0)
    u = low + rng.uniform(0.3, 0.7, (count, shooting.nu)) * (high - low)
    x = np.empty((count, shooting.nx))
    for row, own in zip(x, u, strict=True):
        commands = np.zeros(len(smooth))
        commands[shooting.driven] = own
        row[:] = [*q, rng.normal(), *shooting.start(q, 0.8 * commands)]
    _check_derivatives(shooting, x, u, np.full(count, 1e-5))


def test_derivatives_with_loops_match_differences() -> None:
    """A state with gaps is closed at the end of a step."""
    robot = five_bar()
    shooting, rng = Shooting(robot, STEPS), np.random.default_rng(4)
    q = np.array([c.initial for c in robot.coordinates])
    x = np.array([[*q, *rng.normal(size=4)] for _ in range(4)])
    _check_derivatives(shooting, x, rng.uniform(10.0, 60.0, (4, shooting.nu)), np.full(4, H))


def test_cable_friction_is_rejected(robot: Robot) -> None:
    with pytest.raises(CardsflowError, match="do not support cable friction"):
        Shooting(with_bent_cables(robot, 0.1, [0.1, 0.2]))


def test_rates_are_the_derivatives_by_time(robot: Robot) -> None:
    shooting, e = Shooting(robot, STEPS), 1e-6
    x, u, h = _arguments(shooting)
    short = shooting.run(x, u, 0 * h + e, False), shooting.run(x, u, 0 * h - e, False)
    assert short[0] is not None
    assert short[1] is not None
    rates = (short[0].ends - short[1].ends) / (2 * e)
    found, tensions = shooting.rates(x, u)
    np.testing.assert_allclose(found, rates, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(tensions, u)


def test_tensions_of_muscle_laws_accelerate_the_robot() -> None:
    """At the same q and qd, M times the difference of qdd is -L' times that of the tensions."""
    shooting, dynamics = _hill_arm(0), CoreDynamics(Experiment.load(EXAMPLES / "hill_arm").robot)
    q, rng = np.array([0.3, 0.5]), np.random.default_rng(5)
    x = np.array([[*q, 0.4, -0.2, *rng.uniform(0.2, 0.8, 6)] for _ in range(2)])
    rates, tensions = shooting.rates(x, np.full((2, 6), 0.5))
    qdd, f = (np.diff(each, axis=0)[0] for each in (rates[:, 2:4], tensions))
    L = dynamics.muscle_jacobian(q)
    np.testing.assert_allclose(dynamics.mass_matrix(q) @ qdd, -L.T @ f, rtol=1e-12)


def test_diverging_motion_is_reported(robot: Robot) -> None:
    shooting = Shooting(robot)
    x, u, h = _arguments(shooting)
    assert shooting.run(x, u * 1e300, h) is None


def test_rates_of_a_state_that_is_not_finite_are_rejected(robot: Robot) -> None:
    shooting = Shooting(robot)
    with pytest.raises(SimulationError, match="are not finite"):
        shooting.rates(np.full((1, shooting.nx), np.nan), np.zeros((1, shooting.nu)))
