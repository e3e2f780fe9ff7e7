"""Robot, controller and control loop as python-control systems, for analysis and design.

    systems = to_nlsys(controller, dynamics, period=0.005)
    x = np.concatenate([q, qd])
    reference = np.concatenate([q_d, np.zeros(2 * n)])
    linear = systems.loop.linearize(x, reference)
    abs(linear.poles()).max()
    response = control.input_output_response(systems.loop, times, references, x)

These systems are for analysis only. Runs do not use them, since python-control evaluates every tick
slowly. `to_nlsys` imports python-control late, since the import takes about 1 s.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, acceleration, actuator_names
from controllers.laws.control_loop import ControlLaw
from controllers.validation import require_delay, require_period


class Systems(NamedTuple):
    """python-control systems with a common period. Vector signals are named `q[0]`, `q[1]`, ...

    Attributes:
        plant: Inputs f; outputs and states q, qd.
        controller: Inputs q, qd, q_d, qd_d, qdd_d; outputs f. With delay, the states are f.
        loop: Inputs q_d, qd_d, qdd_d; outputs q, qd, f; states q, qd. With delay, f is also a
            state.
    """

    plant: Any
    controller: Any
    loop: Any


def to_nlsys(
    controller: ControlLaw,
    dynamics: Dynamics | None = None,
    period: float = 1e-3,
    *,
    delay: int = 0,
    substeps: int = 10,
) -> Systems:
    """Create python-control systems of a robot, its controller and their loop.

    Args:
        controller: A controller in joint space.
        dynamics: The simulated robot (default: the robot model of the controller).
        period: Period T of the controller, in [s]. Forces are constant between ticks.
        delay: Ticks from the measurement of a state until its forces take effect: 0 or 1.
        substeps: Integration steps of the plant per period.

    Raises:
        InputError: The period, the delay or the number of substeps is invalid, or the two robots
            differ in size.
    """
    import control

    robot = controller.dynamics if dynamics is None else dynamics
    _check(controller.dynamics, robot, period, delay, substeps)
    n, m = len(robot.coordinate_names), len(actuator_names(robot))
    state, forces = [*_signals("q", n), *_signals("qd", n)], _signals("f", m)
    reference = [*_signals("q_d", n), *_signals("qd_d", n), *_signals("qdd_d", n)]

    def update_plant(t: float, x: FloatArray, u: FloatArray, params: object) -> FloatArray:
        return np.concatenate(integrate(robot, x[:n], x[n:], u, period, substeps))

    def compute_forces(t: float, x: FloatArray, u: FloatArray, params: object) -> FloatArray:
        q, qd, q_d, qd_d, qdd_d = u.reshape(5, n)
        return controller.solve(q, qd, q_d, qd_d, qdd_d).forces

    def output_pending(t: float, x: FloatArray, u: FloatArray, params: object) -> FloatArray:
        return x

    plant = control.nlsys(
        update_plant, None, inputs=forces, outputs=state, states=state, dt=period, name="plant"
    )
    output = {"outfcn": output_pending, "states": forces} if delay else {"outfcn": compute_forces}
    law = control.nlsys(
        compute_forces if delay else None,
        inputs=[*state, *reference],
        outputs=forces,
        dt=period,
        name="controller",
        **output,
    )
    loop = control.interconnect(
        [plant, law], inputs=reference, outputs=[*state, *forces], dt=period, name="loop"
    )
    return Systems(plant, law, loop)


def integrate(
    dynamics: Dynamics,
    q: FloatArray,
    qd: FloatArray,
    forces: FloatArray,
    duration: float,
    substeps: int = 10,
) -> tuple[FloatArray, FloatArray]:
    """Integrate a robot at constant forces by the classical fourth-order Runge-Kutta method.

    Args:
        dynamics: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        qd: Joint velocities, shape (n,), in [rad/s] or [m/s].
        forces: f, shape (m,), in [N].
        duration: Duration, in [s].
        substeps: Number of integration steps.

    Returns:
        q and qd after the duration, shape (n,) each.
    """
    h = duration / substeps
    x = np.stack([q, qd])

    def rate(x: FloatArray) -> FloatArray:
        return np.stack([x[1], acceleration(dynamics, x[0], x[1], forces)])

    for _ in range(substeps):
        k1 = rate(x)
        k2 = rate(x + 0.5 * h * k1)
        k3 = rate(x + 0.5 * h * k2)
        k4 = rate(x + h * k3)
        x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return x[0], x[1]


def _check(model: Dynamics, robot: Dynamics, period: float, delay: int, substeps: int) -> None:
    sizes = [(len(d.coordinate_names), len(actuator_names(d))) for d in (model, robot)]
    if sizes[0] != sizes[1]:
        raise InputError(
            f"the controller has {sizes[0][0]} coordinates and {sizes[0][1]} muscles and motors,"
            f" the robot has {sizes[1][0]} and {sizes[1][1]}"
        )
    require_period(period)
    require_delay(delay)
    if substeps < 1:
        raise InputError(f"substeps must be at least 1, not {substeps!r}")


def _signals(name: str, size: int) -> list[str]:
    return [f"{name}[{k}]" for k in range(size)]
