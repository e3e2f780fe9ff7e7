from __future__ import annotations

import numpy as np
import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError
from controllers import JointSpaceController
from controllers.analysis.linearise import (
    LinearLoop,
    acceleration,
    close_loop,
    linearise_controller,
    linearise_loop,
    linearise_robot,
)
from sim_dart import DartDynamics, Plant

END = np.array([-0.5, 0.5])
ZERO = np.zeros(2)


class Case:
    """Two-link arm at the end of its motion, with computed torque, Kp 2000, Kd 90."""

    def __init__(self, f_min: float = 10.0) -> None:
        self.dynamics = DartDynamics(planar_2r())
        self.law = JointSpaceController(self.dynamics, 2000.0, 90.0)
        self.law.distribution.set_bounds(np.full(4, f_min), np.full(4, 100.0))
        self.robot = linearise_robot(self.dynamics, END, ZERO, self.controller(END, ZERO))

    def controller(self, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        return self.law.solve(q, qd, END, ZERO, ZERO).forces

    def predicted_loop(self, period: float, delay: int) -> LinearLoop:
        """Return the loop computed from linear models of its parts."""
        K = linearise_controller(self.controller, END, ZERO)
        return close_loop(self.robot, K, period, delay)

    def numeric_loop(self, period: float, delay: int, step: float) -> LinearLoop:
        """Return the loop with the DART plant, linearised numerically."""
        plant = Plant(planar_2r(), step=step)

        def move(q: np.ndarray, qd: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            plant.reset(q, qd)
            for _ in range(round(period / step)):
                plant.step(f)
            return plant.q, plant.qd

        return linearise_loop(move, self.controller, END, ZERO, delay=delay)


def integrate(
    dynamics: DartDynamics, q: np.ndarray, qd: np.ndarray, f: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the state after a period with constant forces, by ten Runge-Kutta steps."""

    def rate(x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[2:], acceleration(dynamics, x[:2], x[2:], f)])

    x, h = np.concatenate([q, qd]), period / 10
    for _ in range(10):
        a = rate(x)
        b = rate(x + h / 2 * a)
        c = rate(x + h / 2 * b)
        x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c))
    return x[:2], x[2:]


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize("period", [0.005, 0.01])
def test_poles_of_linear_and_sampled_loops_are_equal(period: float, delay: int) -> None:
    """Compare exactly sampled linear parts with differences of the complete nonlinear tick."""
    case = Case()

    def move(q: np.ndarray, qd: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return integrate(case.dynamics, q, qd, f, period)

    whole = linearise_loop(move, case.controller, END, ZERO, delay=delay)
    parts = case.predicted_loop(period, delay)
    np.testing.assert_allclose(whole.A, parts.A, atol=1e-5 * np.abs(parts.A).max())
    difference = np.sort_complex(whole.poles) - np.sort_complex(parts.poles)
    assert np.abs(difference).max() < 1e-5
    assert whole.spectral_radius == pytest.approx(parts.spectral_radius, abs=1e-7)


@pytest.mark.parametrize("delay", [0, 1])
def test_dart_loop_converges_to_the_linear_loop_with_its_step(delay: int) -> None:
    case = Case()
    predicted = case.predicted_loop(0.01, delay).spectral_radius
    rough, fine = (
        abs(case.numeric_loop(0.01, delay, step).spectral_radius - predicted)
        for step in (1e-3, 1e-4)
    )
    assert rough < 7e-3
    assert fine < 8e-4
    assert rough == pytest.approx(10.0 * fine, rel=0.1)


@pytest.mark.parametrize(
    ("f_min", "period", "delay", "radius"),
    [
        (10.0, 0.01, 0, 0.728),
        (0.0, 0.01, 1, 1.034),
        (10.0, 0.01, 1, 1.061),
        (20.0, 0.01, 1, 1.123),
        (10.0, 0.005, 0, 0.846),
        (10.0, 0.005, 1, 0.860),
    ],
)
def test_published_spectral_radii(f_min: float, period: float, delay: int, radius: float) -> None:
    """Loops with radii above 1 diverged in simulations with DART at 1 kHz."""
    loop = Case(f_min).numeric_loop(period, delay, 1e-3)
    assert loop.spectral_radius == pytest.approx(radius, abs=1e-3)


@pytest.mark.parametrize(("f_min", "fastest"), [(0.0, 79.0), (10.0, 1759.0), (20.0, 3440.0)])
def test_constant_forces_act_as_negative_springs(f_min: float, fastest: float) -> None:
    assert -np.linalg.eigvals(Case(f_min).robot.stiffness).real.min() == pytest.approx(
        fastest, abs=1.0
    )


def test_linear_robot_has_the_acceleration_of_the_robot() -> None:
    """The accelerations agree to first order for any state and forces."""
    dynamics, rng = DartDynamics(planar_2r()), np.random.default_rng(3)
    for _ in range(20):
        x, f = rng.uniform(-0.5, 0.5, 4), rng.uniform(10.0, 50.0, 4)
        linear = linearise_robot(dynamics, x[:2], x[2:], f)
        dx, df = 1e-5 * rng.normal(size=4), 1e-3 * rng.normal(size=4)
        ahead, behind = (
            acceleration(dynamics, (x + s * dx)[:2], (x + s * dx)[2:], f + s * df) for s in (1, -1)
        )
        change = (ahead - behind) / 2.0
        rate = linear.A @ dx + linear.B @ df
        np.testing.assert_allclose(rate, [*dx[2:], *change], atol=1e-6 * np.abs(change).max())


def test_wrong_operating_points_raise_an_error() -> None:
    case = Case()
    with pytest.raises(InputError, match="forces"):
        linearise_robot(case.dynamics, END, ZERO, [1.0])
    with pytest.raises(InputError, match="q must"):
        linearise_robot(case.dynamics, [np.nan, 0.0], ZERO, np.ones(4))
    with pytest.raises(InputError, match="qd must"):
        linearise_controller(case.controller, END, np.zeros(3))
    with pytest.raises(InputError, match="period"):
        case.robot.sampled(0.0)
    with pytest.raises(InputError, match="delay"):
        case.predicted_loop(0.01, 2)
    with pytest.raises(InputError, match="shape"):
        close_loop(case.robot, np.zeros((4, 3)), 0.01)
