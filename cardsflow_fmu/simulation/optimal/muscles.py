"""Controls and muscle states of an optimal motion: bounds and start."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.muscle_laws import range_of, states_of
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.dynamics import actuator_names
from controllers.force_distribution.gravity_compensation import gravity_compensation
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.optimal.shooting import Shooting

Bounds = tuple[FloatArray, FloatArray]


def actuators(dynamics: CoreDynamics, shooting: Shooting) -> list[int]:
    """Return the indices of the driven actuators among all muscles and motors."""
    return [*shooting.driven, *range(dynamics.m, len(dynamics.f_min))]


def override(values: FloatArray, own: tuple[float, ...]) -> FloatArray:
    """Return values that are replaced by those that are set."""
    given = np.array(own or np.full(len(values), np.nan))
    return np.where(np.isnan(given), values, given)


def require_order(experiment: Experiment, key: str, low: float, high: float) -> None:
    """Check that a maximum is not below the minimum."""
    if low > high:
        what = f"must be at least the minimum, {low:.6g}, not {high:.6g}"
        raise InputError(what, file=experiment.file, key=f"motion.bounds.{key}")


def control_bounds(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, shooting: Shooting
) -> Bounds:
    """Return the bounds of the controls, shape (nu,): forces, or commands of muscle laws."""
    own, names = motion.bounds, actuator_names(dynamics)
    low, high = override(dynamics.f_min, own.f_min), override(dynamics.f_max, own.f_max)
    for k, name in enumerate(names):
        require_order(experiment, f"f_max.{name}", low[k], high[k])
        if k < dynamics.m and low[k] < 0.0:
            what = f"must be at least 0, since a muscle cannot push, not {low[k]!r}"
            raise InputError(what, file=experiment.file, key=f"motion.bounds.f_min.{name}")
    laws = shooting.laws
    least = override(laws.command_low, own.u_min)
    most = override(laws.command_high, own.u_max)
    for k in np.flatnonzero(laws.modelled & ~laws.passive).tolist():
        require_order(experiment, f"u_max.{names[k]}", least[k], most[k])
        low[k] = max(least[k], laws.command_low[k])
        high[k] = min(most[k], laws.command_high[k])
    driven = actuators(dynamics, shooting)
    return low[driven], high[driven]


def resting_controls(
    motion: MotionTable, dynamics: CoreDynamics, shooting: Shooting, q: FloatArray, bounds: Bounds
) -> tuple[FloatArray, FloatArray]:
    """Return controls that hold the robot at q, shape (nu,), and the states of its muscles."""
    m, driven = dynamics.m, actuators(dynamics, shooting)
    limits = np.array([dynamics.f_min, dynamics.f_max])
    are_forces = np.append(~shooting.laws.modelled, np.ones(limits.shape[1] - m, bool))[driven]
    limits[:, np.array(driven)[are_forces]] = np.array(bounds)[:, are_forces]
    forces = gravity_compensation(dynamics, q, *limits)
    shooting.start(q, np.zeros(m))  # moves the core to q
    commands = shooting.laws.resting_commands(forces[:m])
    commands = override(commands, motion.start_command)
    controls = np.concatenate([commands, forces[m:]])[driven]
    return np.clip(controls, *bounds), shooting.start(q, commands)


def state_ranges(shooting: Shooting, dynamics: CoreDynamics) -> Bounds:
    """Return the ranges of the states of the muscles."""
    models = [muscle.model for muscle in dynamics.robot.muscles]
    ranges = [range_of(state, model) for model in models for state in states_of(model)]
    own = ranges if len(ranges) == shooting.nx - 2 * shooting.n else []
    low, high = [low for low, _ in own], [high for _, high in own]
    return np.array(low), np.array(high)
