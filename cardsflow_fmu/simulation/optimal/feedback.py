"""Feed-forward and feedback gains along an optimal motion."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.cosim.signals.muscles import state_ports
from cardsflow_fmu.cosim.signals.ports import motor_signals, muscle_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.feedback import MotionFeedback
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.feedback import Stage, gains_along, stages, stationary_gain
from controllers.optimal.problem import Iterate
from sim_dart.dynamics.core import CoreDynamics

from .muscles import MotionControls, actuators, control_bounds
from .problem import MotionProblem

Rest = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
"""State, controls, gain and weight of a rest."""

_MIN_LENGTH = 2e-3  # of a row, in [s]; gains change slowly
_AT_REST = 1e-3  # speed, in [rad/s] or [m/s]
_DRIFT = 1e-6  # change of a state at rest, in an interval of the gains
_CANNOT_HOLD = (
    "the robot rests at the end, but no forces within the bounds hold it there; change the goal, "
    "or set run.duration to the duration of the motion"
)
_SETTLING = 0.1  # time after the end in which muscles come to hold the robot, in [s]
_DEPARTURE = 1e-3  # largest movement in this time without a note, in [rad] or [m]


def motion_feedback(
    experiment: Experiment, setup: MotionProblem, at: Iterate
) -> tuple[MotionFeedback, tuple[str, ...]]:
    """Compute the feedback along a motion, and the feedback that holds the robot afterwards.

    Args:
        experiment: The experiment.
        setup: Its problem.
        at: The motion.

    Returns:
        The feedback, and a note if the robot cannot hold the pose in which it rests at the end.
    """
    assert experiment.motion is not None
    problem, n = setup.problem, setup.dynamics.n
    interval = at.duration / problem.intervals
    parts = max(int(interval / max(experiment.controller.period, _MIN_LENGTH) + 1e-6), 1)
    settings = experiment.motion.feedback
    deviations = np.full(at.x.shape[1], np.inf)
    deviations[:n], deviations[n : 2 * n] = settings.q, settings.qd or np.inf
    with setup.shooting.using(-(-setup.shooting.steps // parts)):
        linearised = stages(problem, at, deviations, parts)
    if not linearised:
        raise CardsflowError("the simulation of the motion diverges; use more substeps")
    hold = _hold(experiment, setup, at, linearised[-1], interval / parts)
    rests = abs(at.x[-1, n : 2 * n]).max() <= _AT_REST
    has_loops = bool(setup.dynamics.robot.loops)  # trajectory_feedback does not support them
    notes: tuple[str, ...] = ()
    if hold is None and rests and not has_loops:
        notes = (_CANNOT_HOLD,)
    elif hold is not None and setup.shooting.laws.state_names:
        notes = _departure(setup, at, hold, interval / parts)
    x, u, gain, weight = hold or (at.x[-1], at.u[-1], None, linearised[-1].Q)
    gains = gains_along(linearised, weight)
    gains = np.concatenate([gains, gains[-1:] if gain is None else gain[None]])
    times = np.linspace(0.0, at.duration, len(linearised) + 1)
    states = np.array([*(stage.x for stage in linearised), x])
    controls = np.concatenate([np.repeat(at.u, parts, axis=0), u[None]])
    return _with_names(setup, times, states, controls, gains), notes


def _departure(setup: MotionProblem, at: Iterate, hold: Rest, h: float) -> tuple[str, ...]:
    """Return a note if the robot moves after the motion, before its muscles hold it."""
    problem, n, x = setup.problem, setup.dynamics.n, at.x[-1:]
    most, (rest, u, gain, _), last = np.zeros(n), hold, np.array([len(at.u) - 1])
    for _ in range(int(_SETTLING / h) + 1):
        controls = np.clip(u + (rest - x) @ gain.T, problem.u_low[-1], problem.u_high[-1])
        part = problem.dynamics.run(x, controls, np.array([h]), False, at.parameters, last)
        if part is None:
            break
        x = part.ends
        most = np.maximum(most, abs(x - rest)[0, :n])
    k = int(most.argmax())
    if most[k] <= _DEPARTURE:
        return ()
    joint = setup.dynamics.robot.coordinates[k]
    interval = at.duration / problem.intervals
    length = np.ceil(_SETTLING / interval - 1e-9) * interval
    text = "the robot rests at the end, but its muscles do not hold it there yet: afterwards, "
    text += f"{joint.name} moves by {most[k]:.2g} {joint.unit}"
    return (f"{text}; hold = {length:.4g} in the goal reduces this",)


def _hold(
    experiment: Experiment, setup: MotionProblem, at: Iterate, last: Stage, h: float
) -> Rest | None:
    """Return state, controls, gain and weight of a rest at the end; None if it cannot rest."""
    assert experiment.motion is not None
    n, free, shooting = setup.dynamics.n, setup.free, setup.shooting
    dynamics = CoreDynamics(free.robot_at(at.parameters)) if free else setup.dynamics
    if abs(at.x[-1, n : 2 * n]).max() > _AT_REST:
        return None
    q = at.x[-1, :n]
    bounds = control_bounds(experiment, experiment.motion, dynamics, shooting)
    u, states = MotionControls(dynamics, shooting, bounds).at_rest(q)
    x = np.concatenate([q, np.zeros(n), states])
    interval = np.array([len(at.u) - 1])
    rest = shooting.run(x[None], u[None], np.array([h]), True, at.parameters, interval)
    if rest is None or abs(rest.ends[0] - x)[: 2 * n].max() > _DRIFT:
        return None
    stationary = stationary_gain(last._replace(A=rest.A[0], B=rest.B[0]))
    return None if stationary is None else (x, u, *stationary)


def _with_names(
    setup: MotionProblem,
    times: FloatArray,
    states: FloatArray,
    controls: FloatArray,
    gains: FloatArray,
) -> MotionFeedback:
    """Return the feedback with names and forces; states of muscles are in the order of ports."""
    robot, shooting, n = setup.dynamics.robot, setup.shooting, setup.dynamics.n
    laws, driven = shooting.laws, shooting.driven
    torques = controls[:, len(driven) :]
    forces = np.concatenate([shooting.rates(states, controls)[1], torques], axis=1)
    names_of_law = list(laws.state_names)
    ports = [port.name for port in state_ports(robot, "input") if port.name in names_of_law]
    order = [*range(2 * n), *(2 * n + names_of_law.index(name) for name in ports)]
    names = (*(f"{p}.{c.name}" for p in ("q", "qd") for c in robot.coordinates), *ports)
    return MotionFeedback(
        times, forces, controls, states[:, order], gains[:, :, order], control_signals(setup), names
    )


def control_signals(setup: MotionProblem) -> tuple[str, ...]:
    """Return the names of the controls: commands, forces and torques."""
    robot, laws = setup.dynamics.robot, setup.shooting.laws
    commands, pulls = muscle_signals("u", robot), muscle_signals("f", robot)
    motors = [*pulls, *motor_signals("tau", robot)]
    return tuple(
        commands[k] if k < setup.dynamics.m and laws.modelled[k] else motors[k]
        for k in actuators(setup.dynamics, setup.shooting)
    )
