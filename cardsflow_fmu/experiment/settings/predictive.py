"""Settings of model predictive control in [controller]: costs, bounds, supported experiments."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import Context, FromZero, Positive, Table
from cardsflow_fmu.experiment.motion.bounds import RobotBoundSettings
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import CoreDynamics
from sim_dart.estimation.estimated_robot import passive_muscles

from .plant import PlantSettings

MPC = "mpc"
"""Controller type of model predictive control."""


class PredictiveCostSettings(Table):
    """Cost of the predicted motion: weights of integrals over time, as in [motion.cost].

    The defaults follow from kp and kd: without active bounds, the forces are those of the computed
    torque with these gains.
    """

    tracking: tuple[FromZero, ...] = named_setting(
        "followed", "weight of the squared tracking error (default: kp²)", None
    )
    tracking_rates: tuple[FromZero, ...] = named_setting(
        "followed", "weight of its squared rate (default: kd² - 2 kp, at least 0)", None
    )
    accelerations: tuple[FromZero, ...] = named_setting(
        "followed", "weight of its squared acceleration", 1.0
    )
    speeds: tuple[FromZero, ...] = named_setting(
        "coordinate", "weight of the squared joint velocities", 0.0
    )
    forces: tuple[Positive, ...] = named_setting(
        "actuator",
        "weight of the squared forces and torques, minus the pretension (default: so small that "
        "they do not affect the tracking)",
        None,
    )
    force_rates: tuple[FromZero, ...] = named_setting(
        "actuator", "weight of the squared rates of the forces and torques", 0.0
    )


class PredictiveBoundSettings(RobotBoundSettings):
    """Bounds of the predicted motion, as in [motion.bounds].

    Those of positions and speeds are soft, but violations have a high cost. The fallback uses the
    limits of the robot.
    """


def override(values: FloatArray, overrides: tuple[float, ...]) -> FloatArray:
    """Return values, replaced by those that are given and not NaN."""
    replacements = np.array(overrides or np.full(len(values), np.nan))
    return np.where(np.isnan(replacements), values, replacements)


def require_bounds(bounds: PredictiveBoundSettings, robot: Robot, context: Context) -> None:
    """Check that bounds are in order, and those of forces within the limits of the robot.

    Raises:
        InputError: A bound is not valid.
    """
    dynamics, key = CoreDynamics(robot), "controller.bounds"
    actuators = [*(each.name for each in robot.muscles), *(each.name for each in robot.motors)]
    coordinates = [coordinate.name for coordinate in robot.coordinates]
    for symbol, names in {"f": actuators, "q": coordinates}.items():
        limits = getattr(dynamics, f"{symbol}_min"), getattr(dynamics, f"{symbol}_max")
        overrides = getattr(bounds, f"{symbol}_min"), getattr(bounds, f"{symbol}_max")
        least, most = (override(*pair) for pair in zip(limits, overrides, strict=True))
        for k, name in enumerate(names):
            low, high = limits[0][k], limits[1][k]
            for side, value in (("min", least[k]), ("max", most[k])):
                if symbol == "f" and not low <= value <= high:
                    message = f"must be within the limits of the robot, {low:g} to {high:g}"
                    raise context.error(f"{key}.f_{side}.{name}", f"{message}, not {value:g}")
            if least[k] > most[k]:
                message = f"must be at least the minimum, {least[k]:g}, not {most[k]:g}"
                raise context.error(f"{key}.{symbol}_max.{name}", message)


def require_predictable(
    robot: Robot, plant: PlantSettings, has_scene: bool, engine: str, context: Context
) -> None:
    """Check that model predictive control supports an experiment.

    Raises:
        InputError: The experiment has a part that its model of the robot does not include.
    """
    passive = zip(robot.muscles, passive_muscles(robot), strict=True)
    sprung = next((muscle.name for muscle, is_passive in passive if is_passive), None)
    custom = next((m.name for m in robot.muscles if m.model.custom is not None), None)
    unsupported = {
        "closed kinematic loops": bool(robot.loops),
        "contacts; remove [world]": has_scene,
        'plant.engine = "dart"': plant.engine == "dart",
        'controller.engine = "dart"': engine == "dart",
        f"the passive muscle {sprung!r}": sprung is not None,
        f"the custom law of muscle {custom!r} in Python": custom is not None,
    }
    for feature, is_there in unsupported.items():
        if is_there:
            message = f"{MPC!r} does not support {feature}"
            raise InputError(message, file=context.file, key="controller.type")
