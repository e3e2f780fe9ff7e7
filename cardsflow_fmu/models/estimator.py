"""Estimator as an FMU model.

Inputs are measurements; outputs are the state, loads and validity.
"""

from __future__ import annotations

import math
import sys

import numpy as np

from cardsflow_fmu.cosim.signals.dependencies import Dependencies, sampled_dependencies
from cardsflow_fmu.cosim.signals.estimation import estimator_groups, measured_muscles
from cardsflow_fmu.cosim.signals.groups import Groups
from cardsflow_fmu.cosim.signals.reaction import fault_groups
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.faults import FaultsTable
from sim_dart import compile_blob
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.imu_frames import imu_frames

from .c_model import CModel
from .native.fields import Fields, encode
from .sensors import estimator_settings, sensor_indices

_ARRAYS = """
length_noise encoder_noise gyroscope_noise accelerometer_noise compliance slack gate
acceleration_noise load_drift bias_drift offset_drift start_offset_sd imu_rotation imu_position
search starts start_low start_high start_sd largest_sd largest_innovation innovation_time
"""
"""Fields that contain arrays of a `PoseEstimator`."""

_FAULT_ARRAYS = """
false_alarms_per_hour motor_lag length_error tension_noise tension_error command_delay start
force_rate f_max load_noise load_change
"""
"""Fields that contain arrays of a monitor of faults, see controllers/csrc/faults/faults.h."""


def make_estimator(experiment: Experiment) -> PoseEstimator:
    """Create the estimator of an experiment."""
    settings = estimator_settings(experiment)
    return PoseEstimator(
        experiment.robot, settings.estimator_settings, experiment.start.q, settings.inertial_units
    )


def _horizon_fields(estimator: PoseEstimator) -> Fields:
    """Return the fields of a horizon, which has no frames for a Kalman filter."""
    settings = estimator.settings
    if settings.type == "horizon":
        fields: Fields = {name: estimator.array(name, -1) for name in ("huber", "low", "high")}
        return fields | {"frames": settings.frames}
    none = np.zeros(len(estimator.q))
    return {"frames": 0, "huber": 0.0, "low": none, "high": none}


class EstimatorModel(CModel):
    """Estimator with one tick per step, which uses the inputs at the start of the step.

    The first tick computes the start state from its measurements. Each later tick advances the
    state by the previous step. With delayed measurements, ticks before the first measurement have
    no effect.
    """

    description = "State estimator from muscle measurements"

    @staticmethod
    def groups(experiment: Experiment) -> Groups:
        """Return the variables for an experiment in named groups."""
        settings = estimator_settings(experiment)
        assert settings.offset is not None  # set when an experiment is read
        robot, encoded = experiment.robot, settings.encoder_indices
        has_faults = experiment.faults is not None
        groups = {
            **estimator_groups(
                robot,
                encoded,
                settings.links,
                experiment.start.q,
                settings.offset,
                experiment.run.step,
                estimates_offsets=settings.estimator_settings.estimates_offsets,
            ),
            **fault_groups(robot, measured_muscles(robot), encoded, has_faults=has_faults),
        }
        # Models have their inputs first, then outputs, then parameters.
        return {
            name: groups[name]
            for causality in ("input", "output", "parameter")
            for name in groups
            if groups[name] and groups[name][0].causality == causality
        } | {name: () for name in groups if not groups[name]}

    @classmethod
    def dependencies(cls, experiment: Experiment) -> Dependencies:
        """Return the dependencies of the outputs without creating the model."""
        groups = cls.groups(experiment)
        return sampled_dependencies(groups, at_start={"q": "q_start"})

    @classmethod
    def file(cls, experiment: Experiment) -> bytes:
        """Return the contents of the file `native.bin` of the model."""
        settings, robot = estimator_settings(experiment), experiment.robot
        estimator = make_estimator(experiment)
        fields: Fields = sensor_indices(experiment) | {
            "imu_frame": imu_frames(robot, settings.inertial_units).frames,
            "exact": settings.exact_transition,
            "delay": settings.delay(experiment.run.step),
        }
        fields |= {name: estimator.array(name, -1) for name in _ARRAYS.split()}
        fields |= _horizon_fields(estimator)
        fields |= _fault_fields(experiment)
        n, m = len(robot.coordinates), len(robot.muscles)
        counts = {"units": len(settings.imus), "muscles": m, "numbers": 3 * n + 2}
        has_faults = experiment.faults is not None
        counts["tracked"] = len(estimator.offset_changes)
        counts |= {"watched": m * has_faults, "joints": n * has_faults, "monitors": int(has_faults)}
        blob = compile_blob(estimated_robot(robot))
        return encode("estimator", blob, cls.groups(experiment), counts, fields)


def _fault_fields(experiment: Experiment) -> Fields:
    """Return the settings of the detection of faults; without detection they are empty."""
    hardware, settings, none = experiment.hardware, experiment.faults, np.empty(0)
    fields = {"has_tensions": hardware.has_tensions or not hardware.use}
    if settings is None:
        return {**dict.fromkeys(_FAULT_ARRAYS.split(), none), **fields}
    muscles = experiment.robot.muscles
    return {
        **{n: getattr(settings, n) for n in _FAULT_ARRAYS.split() if n in FaultsTable.model_fields},
        **fields,
        "command_delay": float(_command_delay(experiment)),
        "start": hardware.ramp_in if hardware.use else 0.0,
        "force_rate": hardware.force_rate
        if hardware.use and hardware.force_rate
        else [math.inf] * len(muscles),
        "f_max": [min(muscle.f_max, sys.float_info.max) for muscle in muscles],
    }


def _command_delay(experiment: Experiment) -> int:
    """Return the ticks from a command to the measurement of its tension.

    Hardware in real time measures the state at the start of a step.
    """
    if experiment.hardware.use:
        return int(experiment.hardware.is_paced)
    return estimator_settings(experiment).delay(experiment.run.step)
