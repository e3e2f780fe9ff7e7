"""The controller as an FMU model: state, reference and known loads in, muscle commands out."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError, Robot, SimulationError
from addin_sdfusion.robot.model.tension_laws import states_of
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, controller_dependencies
from cardsflow_fmu.cosim.signals.estimation import estimate_inputs
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.muscles import driven_muscles, modelled_muscles, state_order
from cardsflow_fmu.cosim.signals.ports import controller_groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.controller import ControllerSettings
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.qp.law_in_c import number_of
from sim_dart import compile_blob
from sim_dart.core.tasks import point_rows, task_rows
from sim_dart.plant.settings import python_laws

from .c_model import CModel
from .native.fields import Counts, Fields, encode, field_names
from .native.opened_model import OpenedModel
from .plant import motors
from .python_law import PythonParts, law_in_python
from .start_commands import start

LATE_PERIODS = 4
"""Horizon where a muscle has several states, in periods, unless an experiment has another."""


class ControllerModel(CModel):
    """A control law and what a sampled loop needs around it: one tick a step.

    The law is evaluated with the inputs as they stand at the beginning of a step; its forces hold
    until the next.
    """

    description = "Controller of muscle forces"
    has_derivatives = True

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        self.steady_outputs, self._valid = self.indices("report"), self.views["valid"]

    def _open(self, experiment: Experiment) -> OpenedModel:
        opened = self._opened_in_c(experiment)
        self._python: PythonParts | None = None
        if self.missing(experiment) is not None:
            self._python = PythonParts(experiment, opened)
        return opened

    def initialize(self, t: float = 0.0) -> None:
        """Take over gains and bounds.

        Until the first tick, every ideal cable holds its f_min, and motors give no torque; muscles
        with laws hold the robot.
        """
        super().initialize(t)
        if self._python is not None:
            self._python.reset()

    def step(self, t: float, h: float) -> None:
        """A tick with the inputs at t; a step of several periods is a tick of a longer one."""
        python = self._python
        if python is None:
            self.opened.step(t, h)
            return
        try:
            self.opened.step(t, h)
        except SimulationError:
            python.check()
            raise
        python.check()
        if self._valid.size and not self._valid[0]:
            python.reset()

    def get_state(self) -> bytes:
        """The memory of the controller, and of a law in Python behind it."""
        state = super().get_state()
        return state if self._python is None else state + self._python.get_state()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        if self._python is None:
            super().set_state(state)
            return
        end = len(super().get_state())
        if len(state) != end + len(self._python.get_state()):
            raise InputError(f"a state of this controller does not have {len(state)} bytes")
        super().set_state(state[:end])
        self._python.set_state(state[end:])

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups."""
        settings = experiment.controller
        fed = experiment.feeding is not None
        return controller_groups(
            experiment.robot,
            settings.space,
            settings.kp,
            settings.kd,
            settings.period,
            torque_gains=settings.torque_gains,
            estimate=estimate_inputs(experiment.robot) if fed else {},
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""
        settings = experiment.controller
        # a prediction needs all of the reference, whatever the law reads of it
        predicts = settings.delay and settings.predict
        return controller_dependencies(
            experiment.robot,
            cls.groups(experiment),
            () if predicts else settings.law.unread,
            delayed=settings.delay > 0,
        )

    @classmethod
    def missing(cls, experiment: Experiment) -> str | None:
        """What the experiment needs and C does not have, in words; None where it has all."""
        return law_in_python(experiment) or python_laws(experiment.robot)

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """The contents of the model's `native.bin`."""
        fields = _controller_fields(experiment)
        return encode("controller", compile_blob(experiment.robot), cls.groups(experiment), *fields)


def _controller_fields(experiment: Experiment) -> tuple[Counts, Fields]:
    """Counts and fields; a setting whose name is that of a field of the layout is that field."""
    robot, controller = experiment.robot, experiment.controller
    muscles = len(robot.muscles) if modelled_muscles(robot) else 0
    begin = start(robot, experiment.start.q) if muscles else None
    named = [name for name in field_names("controller") if name in ControllerSettings.model_fields]
    fields: Fields = {name: getattr(controller, name) for name in named} | {
        "load_rows": point_rows(robot),
        "motors": motors(robot),
        "state_order": state_order(robot),
        "commanded": driven_muscles(robot),
        "late_periods": late_periods(robot) if muscles else 0.0,
        "start_forces": [] if begin is None else begin.forces,
        "start_commands": [] if begin is None else begin.commands,
        "ramp_down": experiment.feeding.ramp_down if experiment.feeding else 0.0,
        "ramp_in": experiment.feeding.ramp_in if experiment.feeding else 0.0,
        "q_start": experiment.start.q,
        "H_f": controller.actuator_weights,
        "f_p": controller.pretensions,
        "law": _law(controller),
        "passive": np.logical_or(controller.passive, controller.dependent),
    }
    rows = [] if controller.tasks is None else task_rows(robot)
    counts = {"tasks": len(rows), "modelled": muscles, "motors": len(robot.motors)}
    return counts, fields | {"task_rows": rows} | _task_fields(robot, controller)


def _task_fields(robot: Robot, controller: ControllerSettings) -> Fields:
    """What the law in operational space knows; nothing of it for that in joint space."""
    tasks = controller.tasks
    rest, none = np.zeros(len(robot.coordinates)), (0.0,) * len(robot.muscles)
    posture = None if tasks is None else tasks.posture
    is_angle = [frame.is_orientation for frame in robot.task_frames for _ in frame.axes]
    return {
        "is_angle": [] if tasks is None else is_angle,
        "H_q": rest if tasks is None else tasks.acceleration_weights,
        "H_r": controller.with_motors(none if tasks is None else tasks.force_rate_weights),
        "W": [] if tasks is None else tasks.task_weights,
        "priority": [] if tasks is None else tasks.priorities,
        "posture_kp": rest if posture is None else posture.kp,
        "posture_kd": rest if posture is None else posture.kd,
        "q0": rest if posture is None else posture.q0,
        "limit_bandwidth": 0.0 if tasks is None else tasks.limit_bandwidth or 0.0,
    }


def _law(controller: ControllerSettings) -> int:
    """The number of a law in joint space; 0 in operational space and for custom laws."""
    if controller.tasks is not None or controller.own_law is not None:
        return 0
    return number_of(str(controller.type))


def late_periods(robot: Robot) -> int:
    """The horizon of a robot's muscles in periods, unless an experiment has another."""
    return LATE_PERIODS if any(len(states_of(m.model)) > 1 for m in robot.muscles) else 1
