"""Hardware as an FMU model with the ports of the plant."""

from __future__ import annotations

import weakref

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, hardware_dependencies
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.hardware import hardware_groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.hardware.protocol.signals import require_forces
from cardsflow_fmu.hardware.session.connect import Connection, make_session
from cardsflow_fmu.hardware.session.session import STOPPED, HardwareSession
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.multiples import MAX_STEPS, whole_steps
from sim_dart import MusclePaths

from .experiment_model import ExperimentModel


class HardwareModel(ExperimentModel):
    """Robot hardware that is connected by a link. A step consists of one or more exchanges.

    In real time, the state at the end of a step was measured at the start of the step. In lockstep
    it was measured at the end. Load inputs have no effect. The robot must be at the start state of
    the plant. The internal step is not used.

    `close`, garbage collection and the end of the program bring the robot to its safe state.

    Args:
        values: Memory for the variables (default: allocated).
        connection: Connection to the hardware (default: from environment variables).
    """

    description = "Robot hardware with the ports of the plant"
    has_state = False

    def __init__(
        self,
        experiment: Experiment,
        values: FloatArray | None = None,
        connection: Connection | None = None,
    ) -> None:
        super().__init__(experiment, values)
        self._connection = connection
        robot = experiment.robot
        views = self.views
        self._paths = MusclePaths(robot)
        self._forces, self._torques = views["commands"], views["torques"]
        self._q_start = views["q_start"]
        self._q, self._qd, self._lengths, self._tasks = (
            views[name] for name in ("q", "qd", "lengths", "tasks")
        )
        self._tensions, self._report = views["measured_tensions"], views["diagnostics"]
        self._session: HardwareSession | None = None
        self._ending: weakref.finalize[[], HardwareModel] | None = None

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups.

        Raises:
            InputError: The command of a muscle is not its force.
        """
        require_forces(experiment.robot, experiment.file)
        start = experiment.start
        return hardware_groups(
            experiment.robot,
            start.q,
            start.qd,
            experiment.plant.step,
            has_tensions=experiment.hardware.has_tensions,
        )

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        return hardware_dependencies(cls.groups(experiment))

    def initialize(self, t: float = 0.0) -> None:
        """Connect to the hardware; raise an error if it is not at the start state."""
        if self._session is not None and self._session.mode == STOPPED:
            self.close()
        if self._session is None:
            self._connect()
        try:
            self._connected.require_near(self._q_start)
        except BaseException:
            self.close()
            raise
        self._write_outputs()

    def step(self, t: float, h: float) -> None:
        """Exchange commands and states with the hardware from t to t + h, with constant forces."""
        session = self._connected
        count = whole_steps(h, session.step, "the step agreed with the hardware", most=MAX_STEPS)
        try:
            for k in range(count):
                commands = np.concatenate([self._forces, self._torques])
                session.exchange(t + k * session.step, commands)
        finally:
            self._write_outputs()

    def reset(self) -> None:
        """Bring the hardware to its safe state. `initialize` then connects again."""
        self.close()
        super().reset()

    def close(self) -> None:
        """Bring the hardware to its safe state. The outputs retain its last state."""
        if self._ending is not None:
            self._ending()
        if self._session is not None:
            self._write_outputs()
        self._session = self._ending = None

    def get_state(self) -> bytes:
        """Raise InputError, since the state of hardware cannot be saved."""
        raise InputError("the state of hardware cannot be saved")

    def set_state(self, state: bytes) -> None:
        """Raise InputError, since the state of hardware cannot be restored."""
        raise InputError("the state of hardware cannot be restored")

    @property
    def _connected(self) -> HardwareSession:
        if self._session is None:
            raise InputError("the hardware is not connected; call initialize first")
        return self._session

    def _connect(self) -> None:
        session = make_session(self._experiment, self._connection)
        # Hosts that free an FMU only delete its model, without a call of close.
        self._ending = weakref.finalize(self, session.end)
        try:
            session.open()
        except BaseException:
            self.close()
            raise
        self._session = session

    def _write_outputs(self) -> None:
        session = self._connected
        self._q[:] = session.q
        self._qd[:] = session.qd
        self._lengths[:] = session.lengths
        self._tensions[:] = np.concatenate([session.tensions, session.torques])
        self._report[:] = (
            session.age,
            session.missed,
            session.round_trip,
            session.lateness,
            session.mode,
            session.clamped,
        )
        if self._tasks.size:
            self._tasks[:] = self._paths.task_position(session.q)
