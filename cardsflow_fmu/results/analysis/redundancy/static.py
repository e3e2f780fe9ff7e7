"""Static optimisation: muscle activations along a motion.

At each point of the motion, the activations a that move the robot minimise the sum of squares,

    min a'a  s.t.  -L'(F_1 a + F_0) = M qdd + C + G + D qd + w_e,   a_min <= a <= 1,

where F_1 is the difference of the tensions of a muscle at activations 1 and 0, with a rigid tendon,
at its length and velocity, and F_0 is the tension at activation 0. As in OpenSim's
`StaticOptimization`, F_0 omits the passive muscle forces by default. For the pennation angle of
Millard2012 muscles, OpenSim's tool uses a fibre length in the wrong unit. This implementation uses
the correct fibre length.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from addin_sdfusion.robot import InputError, Muscle, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from controllers.arrays import BoolArray
from controllers.force_distribution.methods import distribute
from controllers.force_distribution.over_time.problem import MuscleTrajectory
from sim_dart import MuscleDrive, control_dynamics

RESERVE = 1.0
"""Torque of a reserve actuator at activation 1, in [N·m] or [N]."""
_MIN_ARM = 1e-9  # smallest moment arm of a driven coordinate, as fraction of the largest


@dataclass(frozen=True, eq=False)
class Activations:
    """Activations along a motion.

    Attributes:
        times: T times, in [s].
        muscle_names: m names.
        activations: Shape (T, m).
        forces: Tensions, shape (T, m), in [N].
        coordinate_names: n names.
        reserves: Torques of reserve actuators, shape (T, n), in [N·m] or [N].
        undriven: Coordinates without muscles; reserve actuators provide their whole torque.
        infeasible: Whether the muscles are too weak for the other coordinates, shape (T,).
        trajectory: Muscles with activation dynamics and elastic tendons; None for static
            optimisation.
        trajectory_names: Names of these muscles.
        rigid_names: Muscles among them that are too short to stretch their elastic tendons.
    """

    times: FloatArray
    muscle_names: tuple[str, ...]
    activations: FloatArray
    forces: FloatArray
    coordinate_names: tuple[str, ...]
    reserves: FloatArray
    undriven: tuple[str, ...]
    infeasible: BoolArray
    trajectory: MuscleTrajectory | None = None
    trajectory_names: tuple[str, ...] = ()
    rigid_names: tuple[str, ...] = ()


def static_optimisation(robot: Robot, motion: Motion, *, passive: bool = False) -> Activations:
    """Compute the muscle activations of a robot along a motion.

    Args:
        robot: The robot; ideal cables are muscles with f_max.
        passive: Whether to include the passive muscle forces.

    Raises:
        InputError: A muscle has no activation, or no f_max.
    """
    a_min = np.array([_min_activation(muscle) for muscle in robot.muscles])
    dynamics = control_dynamics(robot)
    terms = motion_terms(dynamics, motion)
    L = terms.L[:, : len(robot.muscles)]
    active_force = _active_force(_replace_parameters(robot, _ACTIVE), motion)
    passive_force = _passive_force(_replace_parameters(robot, _RIGID), motion, passive=passive)
    tau = terms.tau + np.einsum("tmn,tm->tn", L, passive_force)
    driven = driven_coordinates(L)
    A, demanded = (L * active_force[:, :, None])[:, :, driven], tau[:, driven]
    distribution = distribute(A, demanded, a_min, 1.0)
    a, infeasible = np.array(distribution.forces), ~distribution.solved
    if infeasible.any():
        a[infeasible] = _with_reserves(A[infeasible], demanded[infeasible], a_min)
    reserves = tau + np.einsum("tmn,tm->tn", L, active_force * a)
    reserves[np.ix_(~infeasible, driven)] = 0.0
    names = np.array(terms.coordinate_names)
    return Activations(
        motion.times,
        tuple(muscle.name for muscle in robot.muscles),
        a,
        active_force * a + passive_force,
        terms.coordinate_names,
        reserves,
        tuple(names[~driven].tolist()),
        infeasible,
    )


def force_range(robot: Robot, motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return the tensions of the muscles along a motion at activations of 0 and 1.

    Tendons are rigid.

    Returns:
        Smallest and largest tensions, shape (T, m) each, in [N].

    Raises:
        InputError: A muscle has no activation, or no f_max.
    """
    rigid = _replace_parameters(robot, _RIGID)
    passive = _passive_force(rigid, motion, passive=True)
    return passive, passive + _active_force(rigid, motion)


def driven_coordinates(L: FloatArray) -> BoolArray:
    """Return whether muscles drive each coordinate, shape (n,), from Jacobians of (T, m, n)."""
    arms = np.abs(L).max(axis=(0, 1), initial=0.0)
    return np.asarray(arms > _MIN_ARM * arms.max(initial=0.0))


def passive_tensions(robot: Robot, motion: Motion) -> FloatArray:
    """Return the tensions of passive muscles along a motion; 0 for other muscles, shape (T, m)."""
    return _passive_force(robot, motion, passive=False)


def _min_activation(muscle: Muscle) -> float:
    """Return the minimum activation; it is 0.01 for muscles of OpenSim."""
    law = law_of(muscle.model)
    default = next((p.default for p in law.parameters if p.name == "minimum_activation"), 0.0)
    return dict(muscle.model.parameters).get("minimum_activation", default or 0.0)


_RIGID = {"elastic_tendon": 0.0, "minimum_activation": 1e-9}
_ACTIVE = _RIGID | {"fibre_damping": 0.0}


def _replace_parameters(robot: Robot, values: Mapping[str, float]) -> Robot:
    """Return the robot with changed parameters of all muscles."""
    changed = []
    for muscle in robot.muscles:
        law = law_of(muscle.model)
        is_scaled = law.command is None or law.command.name in ("excitation", "force")
        if not is_scaled:
            problem = f"muscle {muscle.name!r}: {law.kind!r} has no activation"
            raise InputError(f"{problem}; static optimisation requires Hill-type muscles")
        if law.kind == "ideal" and not np.isfinite(muscle.f_max):
            raise InputError(f"muscle {muscle.name!r}: has no f_max; set it")
        new = {p.name: values[p.name] for p in law.parameters if p.name in values}
        parameters = tuple((dict(muscle.model.parameters) | new).items())
        changed.append(replace(muscle, model=replace(muscle.model, parameters=parameters)))
    return robot.with_muscles(changed)


def _active_force(robot: Robot, motion: Motion) -> FloatArray:
    """Return F_1 along a motion, shape (T, m), in [N]."""
    laws = [law_of(muscle.model) for muscle in robot.muscles]
    full = np.array(
        [
            m.f_max if law.kind == "ideal" else 1.0
            for m, law in zip(robot.muscles, laws, strict=True)
        ]
    )
    minimum, maximum = (_tensions(robot, motion, level, level * full) for level in (0.0, 1.0))
    return np.where([law.command is None for law in laws], 0.0, maximum - minimum)


def _passive_force(robot: Robot, motion: Motion, *, passive: bool) -> FloatArray:
    """Return F_0 along a motion, shape (T, m), in [N]."""
    is_included = [passive or law_of(muscle.model).command is None for muscle in robot.muscles]
    return np.where(is_included, _tensions(robot, motion, 0.0, np.zeros(len(is_included))), 0.0)


def _tensions(robot: Robot, motion: Motion, states: float, commands: FloatArray) -> FloatArray:
    """Return tensions along a motion with all states at one value, shape (T, m), in [N]."""
    drive, tensions = MuscleDrive(robot), np.zeros((len(motion.times), len(robot.muscles)))
    for row, q, qd in zip(tensions, motion.q, motion.qd, strict=True):
        drive.set_state(q, qd, np.full(drive.states, states))
        row[:] = drive.tensions(commands)
    return tensions


def _with_reserves(A: FloatArray, tau: FloatArray, a_min: FloatArray) -> FloatArray:
    """Return activations with reserve actuators at all coordinates, shape (T, m)."""
    n = tau.shape[1]
    both_signs = np.concatenate([RESERVE * np.eye(n), -RESERVE * np.eye(n)])
    rows = np.concatenate([A, np.broadcast_to(both_signs, (len(A), 2 * n, n))], axis=1)
    low = np.concatenate([a_min, np.zeros(2 * n)])
    high = np.concatenate([np.ones_like(a_min), np.full(2 * n, np.inf)])
    return np.asarray(distribute(rows, tau, low, high).forces[:, : len(a_min)])
