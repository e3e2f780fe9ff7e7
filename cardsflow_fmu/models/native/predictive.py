"""Fields of a controller with model predictive control."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.predictive import MPC, override
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from controllers.force_distribution.bounded import ForceDistribution
from sim_dart import CoreDynamics, compile_blob
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.muscles.friction import without_friction
from sim_dart.optimal.shooting import Shooting

from .fields import Counts, Fields

_FORCE_SHARE = 3e-6  # default cost of forces, relative to the squared accelerations they produce
_POSTURE_SHARE = 1e-2  # cost of the posture, relative to that of the tasks
_TOLERANCE = 1e-8  # complementarity, relative to the same accelerations
_WEAK = 1e-6  # squared acceleration of directions without muscles, relative to the largest
_STABLE = 1.4  # fastest rate times a Runge-Kutta step, half of the limit of stability
_MAX_STEPS = 1000  # Runge-Kutta steps of an interval
_SHORT = 1e-4  # interval from which rates are computed, in [s]
_VIOLATION = 20.0  # cost of violated bounds, relative to the largest cost of tracking


def predictive_fields(experiment: Experiment) -> tuple[Counts, Fields, dict[str, FloatArray]]:
    """Return counts, fields, and arrays of mpc.h; see `encode`. Without mpc, they are empty."""
    if experiment.controller.type != MPC:
        return {"plan_bytes": 0}, {"nodes": 0, "plan_steps": 0, "plan_robot": []}, {}
    robot = estimated_robot(without_friction(experiment.robot))
    blob = compile_blob(robot)
    fields: Fields = {
        "nodes": experiment.controller.nodes,
        "plan_steps": _runge_kutta_steps(experiment, robot),
        "plan_robot": np.frombuffer(blob, np.uint8),
    }
    arrays = {f"mpc.{name}": array for name, array in _arrays(experiment).items()}
    return {"plan_bytes": len(blob)}, fields, arrays


def _runge_kutta_steps(experiment: Experiment, robot: Robot) -> int:
    """Return the Runge-Kutta steps with which an interval is stable, near a rest at the start."""
    dynamics, settings = CoreDynamics(experiment.robot), experiment.controller
    rest = np.zeros((3, 1, len(robot.coordinates)))
    rest[0] = experiment.start.q
    terms = motion_terms(dynamics, Motion(np.zeros(1), *rest))
    distribution = ForceDistribution(dynamics.f_min, dynamics.f_max, motors=terms.motors)
    forces = distribution.solve(terms.L[0], terms.tau[0], dynamics.mass_matrix(rest[0, 0])).forces
    near = Shooting(robot).run(rest[:2].reshape(1, -1), forces[None], np.array([_SHORT]))
    if near is None:
        return 1
    rates = np.log(np.linalg.eigvals(near.A[0]).astype(complex)) / _SHORT
    interval = settings.predicted_time / settings.nodes
    return int(np.clip(np.ceil(abs(rates).max() * interval / _STABLE), 1, _MAX_STEPS))


def _arrays(experiment: Experiment) -> dict[str, FloatArray]:
    """Return the arrays of the law by their C names, with defaults that follow from the gains."""
    settings, robot = experiment.controller, experiment.robot
    cost, bounds = settings.cost, settings.bounds
    kp, kd = np.array(settings.kp), np.array(settings.kd)
    follows = np.ones(len(kp))
    if settings.space == "joint":
        follows = 1.0 - np.array(settings.uncontrolled, float)
    tracking, rates = np.array(cost.tracking or kp**2), np.array(cost.tracking_rates)
    if not cost.tracking_rates:
        rates = np.maximum(kd**2 - 2.0 * kp, 0.0)
    accelerations = np.array(cost.accelerations)
    law = {name: np.array(array) for name, array in settings.law_arrays().items()}
    weights, scale = law["H_f"], _acceleration_per_force(experiment)
    interval = settings.predicted_time / settings.nodes
    dynamics = CoreDynamics(robot)
    arrays = {
        "horizon": np.array([settings.predicted_time]),
        "iterations": np.array([settings.iterations], float),
        "tracking": follows * tracking,
        "tracking_rates": follows * rates,
        "accelerations": follows * accelerations,
        "speeds": np.array(cost.speeds),
        "forces_cost": np.array(cost.forces or _FORCE_SHARE * scale * weights / weights.mean()),
        "force_rates": np.array(cost.force_rates),
        "f_p": law["f_p"],
        "deadline": np.array([settings.deadline or 0.0]),
        "plan_min": override(dynamics.f_min, bounds.f_min),
        "plan_max": override(dynamics.f_max, bounds.f_max),
        "q_min": override(dynamics.q_min, bounds.q_min),
        "q_max": override(dynamics.q_max, bounds.q_max),
        "qd_max": override(np.full(len(robot.coordinates), np.inf), bounds.qd_max),
        "limit_penalty": np.full(
            len(robot.coordinates), _VIOLATION * settings.predicted_time * tracking.max()
        ),
        "tolerance": np.array([_TOLERANCE * interval * accelerations.max()]),
    }
    return arrays | (_posture(experiment) if settings.tasks is not None else {})


def _posture(experiment: Experiment) -> dict[str, FloatArray]:
    posture = experiment.controller.posture
    if posture is None:
        return {}
    kp, kd = np.array(posture.kp), np.array(posture.kd)
    share = _POSTURE_SHARE * np.array(experiment.controller.acceleration_weights)
    return {
        "posture": share * kp**2,
        "posture_rates": share * np.maximum(kd**2 - 2.0 * kp, 0.0),
        "posture_accelerations": share,
        "q0": np.array(posture.q0),
    }


def _acceleration_per_force(experiment: Experiment) -> float:
    """Return the smallest squared acceleration that forces of 1 N produce in a direction.

    It is the one at the start. Directions without muscles do not count.
    """
    dynamics, q = CoreDynamics(experiment.robot), np.array(experiment.start.q)
    moved = np.linalg.solve(dynamics.mass_matrix(q), dynamics.actuator_jacobian(q).T)
    squares = np.linalg.svd(moved, compute_uv=False) ** 2
    return float(squares[squares > _WEAK * squares[0]].min())
