"""Controller as an FMU model.

Inputs are the state, the reference and known loads; outputs are the muscle commands.
"""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.muscle_laws import states_of
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, controller_dependencies
from cardsflow_fmu.cosim.signals.estimation import estimate_inputs, measured_muscles
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, modelled_muscles, state_order
from cardsflow_fmu.cosim.signals.ports import controller_groups
from cardsflow_fmu.cosim.signals.reaction import full_bounds
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.policy import read_policy
from cardsflow_fmu.experiment.settings.predictive import MPC
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import compile_blob
from sim_dart.core.tasks import point_rows, task_rows
from sim_dart.plant.settings import custom_law_feature

from .c_model import CModel
from .native.fields import Counts, Fields, encode
from .native.motion_fields import motion_fields
from .native.opened_model import OpenedModel
from .native.predictive import predictive_fields
from .plant import motors
from .python_law import PythonController, law_in_python
from .reference import reference_parts
from .start_commands import start

LATE_PERIODS = 4
"""Default horizon for muscles with several states, in periods."""


class ControllerModel(CModel):
    """Control law and sampled control loop with one tick per step.

    The law uses the inputs at the start of a step. Its forces are constant until the next step.
    Before the first tick, ideal cables have the force f_min, motors have zero torque, and muscles
    with laws have the commands that hold the robot.
    """

    description = "Controller of muscle forces"

    opened: OpenedModel | PythonController

    def _open(self, experiment: Experiment) -> OpenedModel | PythonController:
        opened = self._opened_in_c(experiment)
        if self.missing(experiment) is None:
            return opened
        return PythonController(experiment, opened, self.views["valid"])

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        settings = experiment.controller
        fed = experiment.feedback_estimator is not None
        return controller_groups(
            experiment.robot,
            settings.space,
            settings.kp,
            settings.kd,
            settings.period,
            torque_gains=settings.torque_gains,
            is_predictive=settings.type == MPC,
            estimate=estimate_inputs(experiment.robot) if fed else {},
            bounded=_bounded(experiment),
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        settings = experiment.controller
        # The prediction uses the complete reference.
        predicts = settings.delay and settings.predict
        return controller_dependencies(
            experiment.robot,
            cls.groups(experiment),
            () if predicts else settings.law.unread,
            delayed=settings.delay > 0,
        )

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """Return a requirement of the experiment that C does not support, or None."""
        return law_in_python(experiment) or custom_law_feature(experiment.robot)

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        fields = _controller_fields(experiment)
        return encode("controller", compile_blob(experiment.robot), cls.groups(experiment), *fields)


def _controller_fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """Return counts and fields of the layout of a controller; see `encode`."""
    robot, controller = experiment.robot, experiment.controller
    muscles = len(robot.muscles) if modelled_muscles(robot) else 0
    begin = start(robot, experiment.start.q, experiment.feedback) if muscles else None
    plan_counts, plan_fields, plan_arrays = predictive_fields(experiment)
    arrays = controller.law_arrays() | plan_arrays
    names = "".join(f"{name}\0" for name in arrays).encode()
    values = np.concatenate([np.ravel(np.asarray(array, float)) for array in arrays.values()])
    rows = [] if controller.tasks is None else task_rows(robot)
    is_angle = [frame.is_orientation for frame in robot.task_frames for _ in frame.axes]
    fields: Fields = {
        "load_rows": point_rows(robot),
        "task_rows": rows,
        "motors": motors(robot),
        "is_angle": is_angle if rows else [],
        "state_order": state_order(robot),
        "commanded": driven_muscles(robot),
        "muscle_horizon": controller.muscle_horizon,
        "late_periods": late_periods(robot) if muscles else 0.0,
        "start_forces": [] if begin is None else begin.forces,
        "start_commands": [] if begin is None else begin.commands,
        "observer": controller.observer,
        "ramp_down": experiment.feedback_estimator.ramp_down
        if experiment.feedback_estimator
        else 0.0,
        "ramp_in": experiment.feedback_estimator.ramp_in if experiment.feedback_estimator else 0.0,
        "q_start": experiment.start.q,
        "dependent": controller.dependent,
        "array_names": np.frombuffer(names, np.uint8),
        "array_values": values,
    }
    policy = policy_numbers(experiment)
    fields["policy"] = policy
    counts = {"tasks": len(rows), "modelled": muscles, "motors": len(robot.motors)}
    counts["policy_numbers"] = policy.size
    # The future reference; an external FMU does not provide it.
    knows_reference = controller.type == MPC and "reference" not in experiment.fmus
    part_counts, parts = reference_parts(experiment if knows_reference else None)
    motion_counts, of_motion = motion_fields(experiment)
    reaction_counts, reaction = _reaction_fields(experiment)
    counts |= {"letters": len(names), "numbers": values.size}
    return (
        counts | plan_counts | part_counts | motion_counts | reaction_counts,
        fields | plan_fields | parts | of_motion | reaction,
    )


def _bounded(experiment: Experiment) -> list[int]:
    """Return the muscles whose loss the controller reacts to."""
    return measured_muscles(experiment.robot) if experiment.reacts_to_faults else []


def _reaction_fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """Return the table of the reaction to lost muscles; see `encode`."""
    robot, table, bounded = experiment.robot, experiment.look_ahead, _bounded(experiment)
    times = () if table is None or not bounded else table.times
    speeds = [] if table is None else [table.speeds[robot.muscles[k].name] for k in bounded]
    fields: Fields = {
        "bounded": bounded,
        "full_bounds": full_bounds(robot, bounded),
        "reaction_begins": times,
        "reaction_speeds": speeds,
    }
    return {"reaction_times": len(times), "reaction_numbers": len(times) * len(bounded)}, fields


def policy_numbers(experiment: Experiment) -> FloatArray:
    """Return the numbers of the policy; empty without one."""
    settings, robot = experiment.controller, experiment.robot
    if settings.policy is None:
        return np.empty(0)
    policy = read_policy(settings.policy)
    if abs(settings.period - policy.step) > 1e-9 * policy.step:
        problem = f"must be {policy.step} s, the step of the policy, not {settings.period} s"
        raise InputError(problem, file=experiment.file, key="controller.period")
    try:
        return policy.numbers(robot, settings.space)
    except InputError as error:
        error.file = settings.policy
        raise


def late_periods(robot: Robot) -> int:
    """Return the default horizon for the muscles of a robot, in periods."""
    return LATE_PERIODS if any(len(states_of(m.model)) > 1 for m in robot.muscles) else 1
