"""Simulated sensors as an FMU model: the true state in, readings out."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.dependencies import Dependencies, sampled_dependencies
from cardsflow_fmu.signals.estimation import measured_muscles, sensor_groups
from cardsflow_fmu.signals.groups import Groups
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.estimation.sensors import RobotSensors

from .experiment_model import ExperimentModel

READINGS = (
    *("lengths", "measured_tensions", "measured_torques", "encoders"),
    *("gyroscopes", "accelerometers"),
)
"""Groups of readings, in the order of the sensors' channels."""


def reading_channels(experiment: Experiment) -> list[int]:
    """The sensors' channel of each reading, in the order of their ports."""
    robot, settings = experiment.robot, experiment.estimator
    assert settings is not None
    n, m, i = len(robot.coordinates), len(robot.muscles), len(settings.units)
    muscles = measured_muscles(robot)
    motors = [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated]
    return [
        *muscles,
        *(m + k for k in muscles),
        *(2 * m + j for j in motors),
        *(2 * m + n + j for j in settings.encoded),
        *(2 * m + 2 * n + k for k in range(6 * i)),
    ]


class SensorsModel(ExperimentModel):
    """Sensors, which read once a step with the inputs at its beginning."""

    description = "Simulated sensors of muscles, joints and links"
    any_step = True

    def __init__(self, experiment: Experiment, values: FloatArray | None = None) -> None:
        super().__init__(experiment, values)
        settings = experiment.estimator
        if settings is None:
            raise InputError("there is no [estimator] whose sensors these are", key="estimator")
        robot = experiment.plant_robot
        self._sensors = RobotSensors(
            robot,
            settings.sensor_settings(robot, experiment.run.step),
            settings.inertial_units,
        )
        self._q, self._qd, self._tensions, self._torques = (
            self.views[name] for name in ("q", "qd", "tensions", "torques")
        )
        self._muscles = measured_muscles(robot)
        self._motors = [j for j, c in enumerate(robot.coordinates) if c.actuated]
        self._channels = reading_channels(experiment)
        self._readings = self.values[self.indices(*READINGS)[0] :][: len(self._channels)]

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """The variables for an experiment in named groups."""
        settings = experiment.estimator
        assert settings is not None
        return sensor_groups(experiment.robot, settings.encoded, settings.links)

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """What the outputs depend on, without making the model."""
        settings = experiment.estimator
        delayed = settings is not None and settings.sensors.delay > 0
        return sampled_dependencies(cls.groups(experiment), delayed=delayed)

    def initialize(self, t: float = 0.0) -> None:
        """Forget all readings; they are 0 until the first."""
        self._sensors.reset()
        self._readings[:] = 0.0

    def step(self, t: float, h: float) -> None:
        """A reading of the inputs at t."""
        sensors = self._sensors
        sensors.q[:], sensors.qd[:] = self._q, self._qd
        sensors.tensions[self._muscles] = self._tensions
        sensors.torques[self._motors] = self._torques
        sensors.read(h)
        self._readings[:] = sensors.readings[self._channels]

    def get_state(self) -> bytes:
        """The last readings and their number."""
        return self._sensors.get_state().tobytes()

    def set_state(self, state: bytes) -> None:
        """Go back to a state from `get_state`."""
        size = 8 * self._sensors.get_state().size
        if len(state) != size:
            raise InputError(f"a state of these sensors has {size} bytes, not {len(state)}")
        self._sensors.set_state(np.frombuffer(state))
