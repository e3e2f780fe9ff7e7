"""Controls and muscle states of an optimal motion: bounds and start."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.muscle_laws import range_of, states_of
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.experiment.settings.predictive import override
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from controllers.dynamics import actuator_names
from controllers.force_distribution.bounded import ForceDistribution
from sim_dart import MuscleDrive
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.optimal.shooting import Shooting

Bounds = tuple[FloatArray, FloatArray]

# Excess of passive tensions that feedback can balance, over the largest tension.
_TOLERATED_EXCESS = 0.2


def actuators(dynamics: CoreDynamics, shooting: Shooting) -> list[int]:
    """Return the indices of the driven actuators among all muscles and motors."""
    return [*shooting.driven, *range(dynamics.m, len(dynamics.f_min))]


def require_order(experiment: Experiment, key: str, low: float, high: float) -> None:
    """Check that a maximum is not below the minimum."""
    if low > high:
        problem = f"must be at least the minimum, {low:.6g}, not {high:.6g}"
        raise InputError(problem, file=experiment.file, key=f"motion.bounds.{key}")


def control_bounds(
    experiment: Experiment, motion: MotionTable, dynamics: CoreDynamics, shooting: Shooting
) -> Bounds:
    """Return the bounds of the controls, shape (nu,): forces, or commands of muscle laws."""
    bounds, names = motion.bounds, actuator_names(dynamics)
    low, high = override(dynamics.f_min, bounds.f_min), override(dynamics.f_max, bounds.f_max)
    for k, name in enumerate(names):
        require_order(experiment, f"f_max.{name}", low[k], high[k])
        if k < dynamics.m and low[k] < 0.0:
            problem = f"must be at least 0, since a muscle cannot push, not {low[k]:g}"
            raise InputError(problem, file=experiment.file, key=f"motion.bounds.f_min.{name}")
    laws = shooting.laws
    least = override(laws.command_low, bounds.u_min)
    most = override(laws.command_high, bounds.u_max)
    for k in np.flatnonzero(laws.modelled & ~laws.passive).tolist():
        require_order(experiment, f"u_max.{names[k]}", least[k], most[k])
        low[k] = max(least[k], laws.command_low[k])
        high[k] = min(most[k], laws.command_high[k])
    driven = actuators(dynamics, shooting)
    return low[driven], high[driven]


class MotionControls:
    """Controls that move a robot along poses, and the resting states of its muscles.

    The forces are the smallest ones within the bounds; if none produce a torque, those with the
    smallest acceleration error.

    Args:
        dynamics: The robot; with loops, in independent coordinates.
        shooting: Its motion over intervals.
        bounds: From `control_bounds`.

    Attributes:
        dynamics: The robot.
    """

    def __init__(self, dynamics: CoreDynamics, shooting: Shooting, bounds: Bounds) -> None:
        self.dynamics, self._shooting, self._bounds = dynamics, shooting, bounds
        self._driven, modelled = actuators(dynamics, shooting), shooting.laws.modelled
        self._limits = np.array([dynamics.f_min, dynamics.f_max])
        motors = np.ones(self._limits.shape[1] - dynamics.m, bool)
        are_forces = np.append(~modelled, motors)[self._driven]
        self._limits[:, np.array(self._driven)[are_forces]] = np.array(bounds)[:, are_forces]

    def at_rest(
        self, q: FloatArray, commands: tuple[float, ...] = ()
    ) -> tuple[FloatArray, FloatArray]:
        """Return controls that hold a pose, shape (nu,), and states, shape (nx - 2 n,).

        Args:
            q: Joint positions, shape (n,), in [rad] or [m].
            commands: Commands of all muscles that replace the computed ones; nan keeps one.
        """
        rest = np.zeros((1, len(q)))
        controls, states = self.along(Motion(np.zeros(1), q[None], rest, rest), commands)
        return controls[0], states[0]

    def along(
        self, motion: Motion, commands: tuple[float, ...] = ()
    ) -> tuple[FloatArray, FloatArray]:
        """Return the controls and states at the points of a motion, shapes (T, nu) and (T, ...)."""
        terms, pairs = motion_terms(self.dynamics, motion), []
        m, laws, shooting = self.dynamics.m, self._shooting.laws, self._shooting
        for q, L, tau in zip(motion.q, terms.L, terms.tau, strict=True):
            reach = self._limits.copy()
            shooting.start(q, np.zeros(m))  # moves the core to the pose
            if laws.modelled.any():  # as at the start of a run: tensions that the laws reach
                reach[:, :m] = np.maximum(np.clip(reach[:, :m], *laws.resting_reach()), 0.0)
            distribution = ForceDistribution(*reach, motors=terms.motors)
            forces = distribution.solve(L, tau, self.dynamics.mass_matrix(q)).forces
            u_of_muscles = override(laws.resting_commands(forces[:m]), commands)
            u = np.concatenate([u_of_muscles, forces[m:]])[self._driven]
            pairs.append((np.clip(u, *self._bounds), shooting.start(q, u_of_muscles)))
        controls, states = map(np.array, zip(*pairs, strict=True))
        return controls, states


def below_reach(experiment: Experiment, q: FloatArray, tensions: FloatArray) -> tuple[str, ...]:
    """Return a line about the muscle that pulls most beyond its tension in a motion, if any does.

    Args:
        experiment: The experiment.
        q: Joint positions, shape (k, n), in [rad] or [m].
        tensions: Tensions of the motion, shape (k, m), in [N]; nan for passive muscles.
    """
    drive = MuscleDrive(experiment.robot)
    least = np.array([drive.resting_reach(row).low for row in q])
    excess = np.nanmax(np.where(np.isfinite(least), least - tensions, 0.0), axis=0, initial=0.0)
    k = int(excess.argmax())
    if excess[k] <= _TOLERATED_EXCESS * np.nanmax(tensions, initial=0.0):
        return ()
    at = int(np.nanargmax(least[:, k] - tensions[:, k]))
    name, low = experiment.robot.muscles[k].name, least[at, k]
    note = f"the motion will not be followed exactly: at rest, muscle {name} pulls with at least "
    note += f"{low:.4g} N, not with {tensions[at, k]:.4g} N"
    return (f'{note}; use motion.muscles = "laws"',)


def state_ranges(shooting: Shooting, dynamics: CoreDynamics) -> Bounds:
    """Return the ranges of the states of the muscles."""
    models = [muscle.model for muscle in dynamics.robot.muscles]
    ranges = [range_of(state, model) for model in models for state in states_of(model)]
    state_range = ranges if len(ranges) == shooting.nx - 2 * shooting.n else []
    low, high = [low for low, _ in state_range], [high for _, high in state_range]
    return np.array(low), np.array(high)
