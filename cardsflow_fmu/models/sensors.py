"""Simulated sensors as an FMU model. Inputs are the true state; outputs are measurements."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.dependencies import Dependencies, sampled_dependencies
from cardsflow_fmu.cosim.signals.estimation import measured_muscles, sensor_groups
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.estimator import EstimatorTable
from sim_dart import compile_blob
from sim_dart.estimation.estimated_robot import cable_compliances, estimated_robot
from sim_dart.estimation.imu_frames import imu_frames

from .c_model import CModel
from .native.fields import Fields, encode
from .plant import break_times


class SensorsModel(CModel):
    """Sensors that measure once per step, with the inputs at the start of the step."""

    description = "Simulated sensors of muscles, joints and links"
    any_step = True

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        settings = estimator_settings(experiment)
        return sensor_groups(experiment.robot, settings.encoder_indices, settings.links)

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        delayed = estimator_settings(experiment).sensors.delay > 0
        return sampled_dependencies(cls.groups(experiment), delayed=delayed)

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        settings, robot = estimator_settings(experiment), experiment.plant_robot
        sensors = settings.sensor_settings(robot, experiment.run.step)
        units = imu_frames(robot, settings.inertial_units)
        n, m, i = len(robot.coordinates), len(robot.muscles), len(settings.imus)
        fields: Fields = sensor_indices(experiment) | {
            "imu_frame": units.frames,
            "imu_rotation": units.rotations,
            "imu_position": units.positions,
            "delay": sensors.delay,
            "seed": float(sensors.seed),
            "compliance": cable_compliances(robot),
        }
        fields |= {key: getattr(sensors, key) for key in ("noise", "resolution", "offset")}
        stuck = np.array(sensors.stuck)
        stuck[:m] = np.minimum(stuck[:m], break_times(experiment.plant))  # these motors hold
        fields["stuck"] = stuck
        counts = {"units": i, "channels": 2 * m + 2 * n + 6 * i, "muscles": m}
        blob = compile_blob(estimated_robot(robot))
        return encode("sensors", blob, cls.groups(experiment), counts, fields)


def estimator_settings(experiment: Experiment) -> EstimatorTable:
    """Return the table [estimator] of an experiment."""
    if experiment.estimator is None:
        raise InputError("the experiment has no table [estimator]", key="estimator")
    return experiment.estimator


def sensor_indices(experiment: Experiment) -> Fields:
    """Return the indices of measured muscles, of motors and of coordinates with encoders."""
    robot = experiment.robot
    return {
        "measured": measured_muscles(robot),
        "motors": [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated],
        "encoded": estimator_settings(experiment).encoder_indices,
    }
