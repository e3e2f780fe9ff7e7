"""Files of native sensors and estimators; see native/layout.h."""

from __future__ import annotations

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.estimator import make_estimator
from cardsflow_fmu.signals.estimation import measured_muscles
from cardsflow_fmu.signals.groups import Groups
from sim_dart import compile_blob
from sim_dart.estimation.estimated_robot import cable_compliances, estimated_robot
from sim_dart.estimation.unit_places import unit_places

from .fields import Fields, encode

_OF_ESTIMATOR = """
length_noise encoder_noise gyroscope_noise accelerometer_noise compliance slack gate
acceleration_noise load_drift bias_drift imu_rotation imu_position search starts start_low
start_high start_sd largest_sd largest_innovation innovation_time
"""
"""Fields that are arrays of an estimator."""


def sensors_file(experiment: Experiment, groups: Groups) -> bytes:
    """The contents of native sensors' file."""
    settings, robot = experiment.estimator, experiment.plant_robot
    assert settings is not None
    sensors = settings.sensor_settings(robot, experiment.run.step)
    places = unit_places(robot, settings.inertial_units)
    n, m, i = len(robot.coordinates), len(robot.muscles), len(settings.units)
    fields: Fields = _places(experiment) | {
        "imu_frame": places.frames,
        "imu_rotation": places.rotations,
        "imu_position": places.positions,
        "delay": sensors.delay,
        "seed": float(sensors.seed),
        "compliance": cable_compliances(robot),
    }
    fields |= {key: getattr(sensors, key) for key in ("noise", "resolution", "offset", "stuck")}
    counts = {"units": i, "channels": 2 * m + 2 * n + 6 * i, "muscles": m}
    return encode("sensors", compile_blob(estimated_robot(robot)), groups, counts, fields)


def estimator_file(experiment: Experiment, groups: Groups) -> bytes:
    """The contents of a native estimator's file."""
    settings, robot = experiment.estimator, experiment.robot
    assert settings is not None
    estimator = make_estimator(experiment)
    fields: Fields = _places(experiment) | {
        "imu_frame": unit_places(robot, settings.inertial_units).frames,
        "exact": settings.exact,
        "delay": settings.delay(experiment.run.step),
    }
    fields |= {name: estimator.array(name, -1) for name in _OF_ESTIMATOR.split()}
    n, m = len(robot.coordinates), len(robot.muscles)
    counts = {"units": len(settings.units), "muscles": m, "numbers": 3 * n + 2}
    return encode("estimator", compile_blob(estimated_robot(robot)), groups, counts, fields)


def _places(experiment: Experiment) -> Fields:
    robot, settings = experiment.robot, experiment.estimator
    assert settings is not None
    return {
        "measured": measured_muscles(robot),
        "motors": [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated],
        "encoded": settings.encoded,
    }
