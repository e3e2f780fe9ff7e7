"""Activations over a whole motion, with activation dynamics and elastic tendons."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, MotionTerms, motion_terms
from controllers.arrays import BoolArray
from controllers.force_distribution.over_time.problem import MuscleProblem, MuscleTrajectory
from controllers.force_distribution.over_time.solver import MuscleTrajectorySolver
from sim_dart import control_dynamics
from sim_dart.muscles.fibres import FIBRE_LAWS, FIBRE_POINT, HillMuscles, has_fibres

from .static import RESERVE, Activations, driven_coordinates, passive_tensions

MAX_FRAMES = 401
FRAME_STEP = 0.01
"""Default time between frames, in [s]."""
_START = 0.1  # first activations
_MIN_TENSION = 0.003  # of isometric, fully active muscles with elastic tendons, over F0
_EVEN = 1e-6  # largest deviation of time steps, relative to a step
_MAX_RESERVE = 1.0  # reserve of muscles that are strong enough, over its torque at a cost of 1


def optimise_activations(
    robot: Robot, motion: Motion, *, reserve: float = RESERVE, power: float = 2.0
) -> Activations:
    """Compute the muscle activations over a whole motion; see `over_time.solver`.

    Passive forces and fibre damping are included.

    Args:
        robot: A robot with Hill-type muscles; other muscles must be passive.
        motion: The motion at equidistant times.
        reserve: Torque of a reserve actuator at a cost of 1, in [N·m] or [N].
        power: Exponent of the excitations in the cost.

    Raises:
        InputError: A muscle has no activation, or an option or the times are invalid.
        CardsflowError: The optimisation does not converge.
    """
    _require_valid(robot, motion, reserve, power)
    dynamics = control_dynamics(robot)
    terms = motion_terms(dynamics, motion)
    hill = np.array([has_fibres(muscle) for muscle in robot.muscles])
    L = terms.L[:, : len(robot.muscles)]
    passive = np.where(hill, 0.0, passive_tensions(robot, motion))
    tau = terms.tau + np.einsum("tmn,tm->tn", L, passive)
    driven = driven_coordinates(L[:, hill])
    fibrous = [muscle for muscle in robot.muscles if has_fibres(muscle)]
    muscles = HillMuscles(robot.with_muscles(fibrous))
    lengths = np.array([dynamics.muscle_lengths(q)[hill] for q in motion.q])
    rates = np.einsum("tmn,tn->tm", L[:, hill], motion.qd)
    rigid = muscles.rigid(lengths, rates)
    elastic = muscles.elastic & _taut(muscles, rigid[0], lengths)
    is_slack = ~elastic & ((lengths <= muscles.slack) | (rigid[0] < muscles.shortest))
    problem = MuscleProblem(
        float(motion.times[1] - motion.times[0]),
        np.where(is_slack[:, :, None], 0.0, L[:, hill])[:, :, driven],
        tau[:, driven],
        lengths,
        muscles,
        elastic,
        *rigid,
        muscles.force,
        muscles.optimal,
        muscles.shortest,
        muscles.low,
        np.full(int(driven.sum()), reserve),
        power,
    )
    trajectory = MuscleTrajectorySolver(problem, np.full_like(lengths, _START)).solve()
    if not trajectory.is_solved:
        failure = f"the optimisation has not converged after {trajectory.iterations} iterations"
        raise CardsflowError(f"{failure}; use other times, or more --frames")
    trajectory = trajectory._replace(tensions=np.where(is_slack, 0.0, trajectory.tensions))
    changed = muscles.elastic & ~elastic
    rigid_names = tuple(m.name for m, is_rigid in zip(fibrous, changed, strict=True) if is_rigid)
    result = _activations(robot, terms, trajectory, tau, (hill, driven, passive), reserve)
    return replace(result, rigid_names=rigid_names)


def _taut(muscles: HillMuscles, fibres: FloatArray, lengths: FloatArray) -> BoolArray:
    """Return whether muscles can stretch their tendons at all frames, shape (m,)."""
    points = np.zeros((*lengths.shape, FIBRE_POINT))
    points[:, :, 0], points[:, :, 1], points[:, :, 3] = 1.0, fibres, lengths
    tension = muscles.fibres(points)[:, :, 0] / muscles.force
    is_long = lengths > muscles.slack
    return np.asarray(((tension > _MIN_TENSION) & is_long).all(axis=0))


def _activations(
    robot: Robot,
    terms: MotionTerms,
    trajectory: MuscleTrajectory,
    tau: FloatArray,
    parts: tuple[BoolArray, BoolArray, FloatArray],
    reserve: float,
) -> Activations:
    hill, driven, passive = parts
    reserves, forces, activations = tau.copy(), passive.copy(), np.zeros_like(passive)
    reserves[:, driven] = trajectory.reserves
    forces[:, hill], activations[:, hill] = trajectory.tensions, trajectory.activations
    names = np.array(terms.coordinate_names)
    muscles = np.array([muscle.name for muscle in robot.muscles])
    return Activations(
        terms.motion.times,
        tuple(muscles.tolist()),
        activations,
        forces,
        terms.coordinate_names,
        reserves,
        tuple(names[~driven].tolist()),
        np.asarray((abs(trajectory.reserves) > _MAX_RESERVE * reserve).any(axis=1)),
        trajectory,
        tuple(muscles[hill].tolist()),
    )


def _require_valid(robot: Robot, motion: Motion, reserve: float, power: float) -> None:
    for muscle in robot.muscles:
        law = law_of(muscle.model)
        if law.command is not None and not has_fibres(muscle):
            problem = f"muscle {muscle.name!r}: --dynamics does not support {law.kind!r}"
            raise InputError(f"{problem}; it supports {', '.join(FIBRE_LAWS)}")
    if not any(has_fibres(muscle) for muscle in robot.muscles):
        raise InputError("the robot has no Hill-type muscles, which --dynamics requires")
    if not 0.0 < reserve < np.inf:
        raise InputError(f"must be positive and finite, not {reserve:g}", key="--reserve")
    if not 1.0 < power <= 10.0:
        raise InputError(f"must be above 1 and at most 10, not {power:g}", key="--power")
    steps = np.diff(motion.times)
    if not 3 <= len(motion.times) <= MAX_FRAMES:
        problem = f"must be from 3 to {MAX_FRAMES} with --dynamics, not {len(motion.times)}"
        raise InputError(f"{problem}; or select times by --begin and --end", key="--frames")
    if abs(steps - steps[0]).max() > _EVEN * steps[0]:
        raise InputError("the times of the motion must be equidistant")
