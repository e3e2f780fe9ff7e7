"""The joint-space controller as an FMU model: state and reference in, muscle forces out."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment import Experiment
from cardsflow_fmu.ports import Port, joint_controller_ports
from cardsflow_fmu.timing import whole_steps
from controllers import JointSpaceController
from sim_dart import DartDynamics

from .experiment_model import ExperimentModel
from .model import FloatArray


class JointSpaceModel(ExperimentModel):
    """Computed torque in joint space, eq. (3): one tick a step.

    The law is evaluated with the inputs as they stand at the beginning of a step; its forces hold
    until the next.

    Args:
        experiment: Whose controller.
        values: Memory for the variables.
    """

    description = "Computed-torque controller in joint space"

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        robot, settings = experiment.robot, experiment.controller
        n, m = len(robot.coordinates), len(robot.muscles)
        self._controller = JointSpaceController(
            DartDynamics(robot),
            settings.kp,
            settings.kd,
            weights=settings.weights,
            solver=settings.solver,
        )
        self._state_and_reference = self.inputs.reshape(5, n)
        self._forces, self._slack, self._infeasible = np.split(self.outputs, [m, m + n])
        self._kp, self._kd, self._f_min, self._f_max, self._period = np.split(
            self.parameters, [n, 2 * n, 2 * n + m, 2 * n + 2 * m]
        )
        self._applied = np.empty(0)

    @staticmethod
    def table(experiment: Experiment) -> list[Port]:
        """The table of variables for an experiment."""
        settings = experiment.controller
        return joint_controller_ports(experiment.robot, settings.kp, settings.kd, settings.period)

    def initialize(self, t: float = 0.0) -> None:
        """Take over gains and bounds; until the first tick, every muscle holds its f_min."""
        self._apply_parameters()
        self._forces[:] = self._f_min
        self._slack[:] = 0.0
        self._infeasible[0] = 0.0

    def step(self, t: float, h: float) -> None:
        """A tick with the inputs at t; the same forces hold through a step of several periods."""
        whole_steps(h, float(self._period[0]), "the controller's period")
        if not np.array_equal(self._applied, self.parameters):
            self._apply_parameters()
        solution = self._controller.solve(*self._state_and_reference)
        self._forces[:] = solution.forces
        self._slack[:] = solution.slack
        self._infeasible[0] = solution.status == "soft"

    def get_state(self) -> bytes:
        """Nothing: the law has no memory."""
        return b""

    def set_state(self, state: bytes) -> None:
        """Nothing to go back to."""
        if state:
            raise InputError(f"this controller has no state, but got {len(state)} bytes")

    def _apply_parameters(self) -> None:
        self._controller.set_gains(self._kp, self._kd)
        self._controller.distribution.set_bounds(self._f_min, self._f_max)
        self._applied = self.parameters.copy()
