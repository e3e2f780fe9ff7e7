"""Fields of a controller that follows an optimal motion with its forces and gains."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.muscles import state_ports
from cardsflow_fmu.cosim.signals.port import motor_signals, muscle_signals
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.feedback import MotionFeedback
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.laws import MuscleLaws

from .fields import Counts, Fields

_FEEDFORWARD, _BY_FORCES, _BY_COMMANDS = 1, 2, 3  # of motion_use in native/layout.h
_NONE: tuple[Counts, Fields] = (
    dict.fromkeys(("motion_rows", "motion_numbers", "motion_controls", "motion_states"), 0),
    {
        "motion_use": 0,
        **{
            f"motion_{name}": [] for name in ("begin", "values", "actuator", "low", "high", "state")
        },
    },
)


def motion_fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """Return counts and fields of the layout of a controller; see `encode`.

    Raises:
        InputError: The optimal motion of the controller does not exist yet.
    """
    settings, feedback, robot = experiment.controller, experiment.feedback, experiment.robot
    if not settings.uses_gains:
        return _NONE
    if feedback is None:
        problem = f'{settings.type!r} requires reference.type = "optimised"'
        raise InputError(problem, file=experiment.file, key="reference.type")
    n, count = len(robot.coordinates), len(feedback.times)
    commands, forces = muscle_signals("u", robot), muscle_signals("f", robot)
    names = [*forces, *motor_signals("tau", robot)]
    actuators = [
        (commands if name in commands else names).index(name) for name in feedback.control_names
    ]
    inputs = [port.name for port in state_ports(robot, "input")]
    states, gains = feedback.states[:, 2 * n :], feedback.gains
    if experiment.hardware.use:  # hardware does not measure the states of muscles
        states, gains = states[:, :0], gains[:, :, : 2 * n]
    of_muscles = feedback.state_names[2 * n : 2 * n + states.shape[1]]
    rows_of_states = [inputs.index(name) for name in of_muscles]
    rows = [feedback.forces, feedback.controls, states, gains.reshape(count, -1)]
    values = np.concatenate(rows, axis=1)
    low, high = _command_ranges(experiment, feedback, actuators)
    use = _BY_COMMANDS if feedback.has_commands else _BY_FORCES
    fields: Fields = {
        "motion_begin": feedback.times,
        "motion_values": values,
        "motion_actuator": actuators,
        "motion_low": low,
        "motion_high": high,
        "motion_state": rows_of_states,
        "motion_use": _FEEDFORWARD if settings.feedforward else use,
    }
    counts = {
        "motion_rows": count,
        "motion_numbers": values.size,
        "motion_controls": len(actuators),
        "motion_states": states.shape[1],
    }
    return counts, fields


def _command_ranges(
    experiment: Experiment, feedback: MotionFeedback, actuators: list[int]
) -> tuple[list[float], list[float]]:
    """Return the ranges of the commands of the controls; infinite for forces and torques."""
    laws = MuscleLaws(experiment.robot, Core(compile_blob(experiment.robot)))
    is_command = [name.startswith("u.") for name in feedback.control_names]
    pairs = list(zip(actuators, is_command, strict=True))
    return (
        [float(laws.command_low[k]) if flag else -np.inf for k, flag in pairs],
        [float(laws.command_high[k]) if flag else np.inf for k, flag in pairs],
    )
