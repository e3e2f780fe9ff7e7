from __future__ import annotations

import numpy as np
import pytest
from support.robots.arms import PointMass

from addin_sdfusion.robot import InputError
from controllers import ControlLoop, JointSpaceController

T = 0.01
NAMES = PointMass.coordinate_names
REST = np.zeros((3, 3))


def loop(mass: PointMass | None = None, kp: float = 100.0, **settings) -> ControlLoop:
    law = JointSpaceController(mass or PointMass(), kp, 2.0 * np.sqrt(kp))
    return ControlLoop(law, NAMES, T, **settings)


def simulate(
    control: ControlLoop,
    ticks: int,
    load=(0.0, 0.0, 0.0),
    mass=2.0,
    *,
    known=None,
    part=1.0,
    measured=False,
):
    """Simulate the mass with scaled forces and a load by semi-implicit Euler; return q per tick."""
    robot = PointMass()
    q, qd, rows, applied = np.zeros(3), np.zeros(3), [], None
    for _ in range(ticks):
        control.tick(q, qd, REST, known, applied=applied)
        made = part * control.acting
        applied = made if measured else None
        qd = qd + T * ((load - robot.muscle_jacobian(q).T @ made) / mass - [0.0, 0.0, 9.81])
        q = q + T * qd
        rows.append(q)
    return np.array(rows)


def test_observer_estimates_a_constant_load_like_a_first_order_filter() -> None:
    load = np.array([3.0, -2.0, 5.0])
    control = loop(observer=30.0)
    for k in range(1, 60, 7):
        control.reset(control.law.dynamics.f_min)
        simulate(control, k + 1, load)
        expected = -load * (1.0 - np.exp(-30.0 * T * k))
        np.testing.assert_allclose(control.disturbance, expected, atol=1e-6)


@pytest.mark.slow
def test_observer_removes_the_error_by_a_load() -> None:
    load = np.array([3.0, -2.0, 5.0])
    sagging, held = simulate(loop(), 600, load)[-1], simulate(loop(observer=30.0), 600, load)[-1]
    np.testing.assert_allclose(sagging, load / 2.0 / 100.0, rtol=1e-6)
    np.testing.assert_allclose(held, 0.0, atol=1e-9)


def test_known_load_is_compensated_without_an_observer() -> None:
    load, control = np.array([3.0, -2.0, 5.0]), loop(observer=30.0)
    np.testing.assert_allclose(simulate(control, 50, load, known=-load)[-1], 0.0, atol=1e-9)
    np.testing.assert_allclose(control.disturbance, 0.0, atol=1e-6)


@pytest.mark.slow
def test_integral_action_removes_the_error_by_a_wrong_mass() -> None:
    sagging = simulate(loop(), 1500, mass=2.4)[-1]
    held = simulate(loop(ki=100.0), 1500, mass=2.4)[-1]
    assert sagging[2] < -0.01
    np.testing.assert_allclose(held, 0.0, atol=1e-6)


def test_integral_action_stops_while_the_law_is_infeasible() -> None:
    weak = PointMass()
    weak.f_max = np.full(6, 10.0)
    control = loop(weak, ki=100.0)
    for _ in range(20):
        solution = control.tick(np.full(3, -1.0), np.zeros(3), REST)
    assert solution.status == "soft"
    assert not control.get_state()[12:15].any()


def test_delayed_forces_take_effect_one_tick_later() -> None:
    control = loop(delay=1)
    reference = REST.copy()
    acting, computed = [], []
    for k in range(4):
        reference[2, 0] = float(k)
        computed.append(control.tick(np.zeros(3), np.zeros(3), reference).forces)
        acting.append(control.acting)
    np.testing.assert_array_equal(acting[0], control.law.dynamics.f_min)
    np.testing.assert_array_equal(acting[1:], computed[:-1])


def test_law_uses_the_predicted_state() -> None:
    """The prediction is exact for constant forces and a constant reference acceleration."""
    seen = []

    class Recording(JointSpaceController):
        def solve(self, q, qd, *reference, **settings):
            seen.append((q, qd, *reference))
            return super().solve(q, qd, *reference, **settings)

    mass = PointMass()
    control = ControlLoop(Recording(mass, 100.0, 20.0), NAMES, T, delay=1)
    q, qd = np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 3.0])
    position, velocity, acceleration = np.array([[1.0, 0, 0], [0.5, 0, 0], [4.0, 0, 0]])
    control.tick(q, qd, np.stack([position, velocity, acceleration]))
    a = np.array([0.0, 0.0, -9.81])  # the forces of antagonists at f_min cancel
    expected = (
        q + T * qd + 0.5 * T**2 * a,
        qd + T * a,
        position + T * velocity + 0.5 * T**2 * acceleration,
        velocity + T * acceleration,
        acceleration,
    )
    np.testing.assert_allclose(seen[0], expected, atol=1e-12)


@pytest.mark.slow
def test_prediction_stabilises_a_loop_with_delay() -> None:
    """With Kp 4000, Kd 126 and 10 ms the loop diverges without prediction."""

    def largest(predict: bool) -> float:
        control = loop(kp=4000.0, delay=1, predict=predict)
        return float(np.abs(simulate(control, 300, load=(1.0, 0.0, 0.0))[-50:]).max())

    assert largest(True) < 1e-3
    assert largest(False) > 0.1


def test_restored_state_repeats_the_ticks() -> None:
    control = loop(observer=30.0, ki=100.0, delay=1)
    simulate(control, 20, (1.0, 2.0, 3.0))
    loop_state, law_state = control.get_state(), control.law.get_state()

    def ticks() -> list[np.ndarray]:
        return [control.tick(np.full(3, 0.01 * k), np.full(3, 0.1), REST).forces for k in range(5)]

    expected = ticks()
    control.set_state(loop_state)
    control.law.set_state(law_state)
    np.testing.assert_array_equal(ticks(), expected)
    with pytest.raises(InputError, match="state of the control loop"):
        control.set_state(loop_state[1:])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"ki": -1.0}, "ki of 'x' must be finite and not negative"),
        ({"ki": [1.0, 2.0]}, "ki must be a number or 3 numbers"),
        ({"observer": -1.0}, "observer must be a finite bandwidth in rad/s"),
        ({"delay": 2}, "delay must be 0 or 1 ticks, not 2"),
        ({"period": 0.0}, "period must be positive"),
    ],
)
def test_wrong_settings_raise_an_error(settings, message) -> None:
    arguments = {"period": T} | settings
    law = JointSpaceController(PointMass(), 100.0, 20.0)
    with pytest.raises(InputError, match=message):
        ControlLoop(law, NAMES, **arguments)


def test_observer_uses_the_measured_tensions() -> None:
    """Muscles with 90 % of the commanded forces do not appear as an external load."""
    measured, unmeasured = loop(observer=30.0), loop(observer=30.0)
    simulate(measured, 30, part=0.9, measured=True)
    simulate(unmeasured, 30, part=0.9)
    assert np.abs(measured.disturbance).max() < 1e-9
    assert np.abs(unmeasured.disturbance).max() > 0.5
