"""Robot model of the estimator."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CableModel, Joint, Robot
from addin_sdfusion.robot.model.muscle_laws import law_of, law_parameters
from sim_dart.core.arrays import BoolArray, FloatArray

_ELASTIC = ("elastic_cable", "series_elastic_motor")


def estimated_robot(robot: Robot) -> Robot:
    """Return the robot with ideal cables as driven muscles, and without joint limits.

    Tensions are measured, so the laws of driven muscles are not needed. Passive muscles keep their
    laws. Joint limits are removed, since a limit would change the velocity if noise moves the
    estimate beyond it. The estimator treats forces of joint limits as loads.
    """
    muscles = (
        muscle if is_passive else replace(muscle, model=CableModel())
        for muscle, is_passive in zip(robot.muscles, passive_muscles(robot), strict=True)
    )
    return without_limits(robot.with_muscles(muscles))


def without_limits(robot: Robot) -> Robot:
    """Return the robot without joint limits."""
    return replace(robot, joints=tuple(map(_unlimited, robot.joints)))


def passive_muscles(robot: Robot) -> BoolArray:
    """Return flags of muscles without command, motor and sensor, shape (m,)."""
    return np.array([law_of(muscle.model).command is None for muscle in robot.muscles], dtype=bool)


def cable_compliances(robot: Robot) -> FloatArray:
    """Return the compliance 1/k of elastic cables, 0 for other muscles, shape (m,), in [m/N].

    The length at the motor is the path length minus the stretch f/k.
    """
    return np.array(
        [
            1.0 / law_parameters(muscle.model)["stiffness"]
            if muscle.model.kind in _ELASTIC
            else 0.0
            for muscle in robot.muscles
        ]
    )


def _unlimited(joint: Joint) -> Joint:
    coordinates = tuple(replace(c, lower=-math.inf, upper=math.inf) for c in joint.coordinates)
    return replace(joint, coordinates=coordinates)
