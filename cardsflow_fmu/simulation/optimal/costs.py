"""Cost of an optimal motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.names import Names
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.costs import TrackingSettings
from cardsflow_fmu.experiment.motion.settings import MotionTable
from cardsflow_fmu.experiment.recorded_motion import read_motion
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.costs import Costs
from controllers.optimal.node_costs import NodeCost, squares
from controllers.references.splines import SplineReference
from sim_dart.dynamics.core import CoreDynamics
from sim_dart.optimal.shooting import Shooting

from .custom_cost import custom_costs
from .muscles import actuators
from .tasks import StateRows, TaskRows

_LATE = 1e-6  # of the end of a recorded motion, in s


def motion_costs(
    experiment: Experiment,
    motion: MotionTable,
    shooting: Shooting,
    dynamics: CoreDynamics,
    goals: Sequence[NodeCost],
) -> Costs:
    """Return the costs of a motion.

    Args:
        experiment: The experiment.
        motion: Its [motion].
        shooting: The motion over intervals.
        dynamics: The robot.
        goals: Costs of goals with a weight.
    """
    cost, driven = motion.cost, actuators(dynamics, shooting)
    weights = cost.forces if motion.muscles == "forces" else cost.commands
    terms = (*cost.force_rates, *cost.speeds, *cost.accelerations, *cost.activations, cost.time)
    is_set = any((*terms, *weights)) or cost.tracking is not None or cost.function is not None
    controls = np.array(weights)[driven] if is_set else np.ones(len(driven))
    activations = dict(zip(dynamics.muscle_names, cost.activations, strict=True))
    names = [name.partition(".") for name in shooting.laws.state_names]
    of_states = [activations[muscle] * (kind == "activation") for kind, _, muscle in names]
    states = np.array([*np.zeros(shooting.n), *cost.speeds, *of_states])
    rates = np.array(cost.force_rates)[driven]
    accelerations = np.zeros(shooting.nx)
    accelerations[shooting.n : 2 * shooting.n] = cost.accelerations
    nodes = list(goals)
    if cost.tracking is not None:
        nodes.append(_tracking(experiment, motion, cost.tracking, dynamics, shooting.nx))
    if cost.function is not None:
        nodes += custom_costs(experiment, motion, dynamics, shooting.nx)
    none = np.zeros(shooting.nu), np.zeros(shooting.nx)
    return Costs(controls, states, rates, cost.time, *none, accelerations, nodes)


def _tracking(
    experiment: Experiment,
    motion: MotionTable,
    settings: TrackingSettings,
    dynamics: CoreDynamics,
    nx: int,
) -> NodeCost:
    """Return the cost of deviations from a recorded motion."""
    is_joint, key = any(settings.q), "motion.cost.tracking.file"
    names = dynamics.coordinate_names if is_joint else dynamics.task_names
    kind = "coordinate" if is_joint else "task coordinate"
    try:
        space = {"joint" if is_joint else "operational": Names(kind, names)}
        lengths = [c.name for c in experiment.robot.coordinates if c.unit == "m"]
        curve = SplineReference(read_motion(settings.file, space, None, lengths))  # type: ignore[arg-type]
        if curve.duration < motion.duration[1] - _LATE:
            problem = f"{settings.file.name} ends after {curve.duration:.6g} s, before the motion"
            raise InputError(f"{problem}; reduce motion.duration")
    except InputError as error:
        error.file, error.key = experiment.file, key
        raise
    weights: FloatArray = np.array(settings.q if is_joint else settings.y)
    rows, N = np.flatnonzero(weights), motion.intervals
    evaluate = StateRows(rows, nx) if is_joint else TaskRows(dynamics, rows, nx)
    target = curve.evaluate(np.linspace(0.0, motion.duration[1], N + 1)).q[:, rows]
    return squares(np.arange(N + 1), True, evaluate, weights[rows], target)
