"""Settings of [motion.bounds] and of the obstacles of a motion."""

from __future__ import annotations

from typing import Annotated

from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    FromZero,
    Listed,
    Positive,
    Table,
    Text,
    Vector3,
    setting,
)

from .goals import FREE


class RobotBoundSettings(Table):
    """Bounds of forces, positions and speeds, in addition to those of the robot."""

    f_min: tuple[float, ...] = named_setting(
        "actuator", "minimum forces and torques (default: of the robot)", None, others=FREE
    )
    f_max: tuple[float, ...] = named_setting(
        "actuator", "maximum forces and torques (default: of the robot)", None, others=FREE
    )
    q_min: tuple[float, ...] = named_setting(
        "coordinate", "minimum joint positions (default: joint limits)", None, others=FREE
    )
    q_max: tuple[float, ...] = named_setting(
        "coordinate", "maximum joint positions (default: joint limits)", None, others=FREE
    )
    qd_max: tuple[FromZero, ...] = named_setting(
        "coordinate", "maximum joint speeds, in rad/s or m/s (default: none)", None, others=FREE
    )


class MotionBoundSettings(RobotBoundSettings):
    """Bounds of the motion, in addition to those of the robot."""

    u_min: tuple[float, ...] = named_setting(
        "muscle", "minimum commands (default: of the muscle law)", None, others=FREE
    )
    u_max: tuple[float, ...] = named_setting(
        "muscle", "maximum commands (default: of the muscle law)", None, others=FREE
    )
    f_rate_max: tuple[Positive, ...] = named_setting(
        "actuator",
        'maximum rates of the forces and torques, per s; of the commands with `muscles = "laws"` '
        "(default: none)",
        None,
        others=FREE,
    )
    y_min: tuple[float, ...] = named_setting(
        "task coordinate",
        "minimum task coordinates, in m or rad (default: none)",
        None,
        others=FREE,
    )
    y_max: tuple[float, ...] = named_setting(
        "task coordinate",
        "maximum task coordinates, in m or rad (default: none)",
        None,
        others=FREE,
    )


class ObstacleSettings(Table):
    """Sphere or capsule that parts of the robot must not enter."""

    centre: Vector3 = setting("centre, in the world frame, in m")
    end: Vector3 = setting("other end of the axis of a capsule, in m (default: a sphere)", None)
    radius: Positive = setting("radius, in m")
    clearance: FromZero = setting(
        "distance of the parts from the surface, in m, such as the radius of the links", 0.0
    )
    points: Annotated[tuple[Text, ...], Listed] = setting(
        "names of the task frames (default: all points, without links and cables)", ()
    )
    links: Annotated[tuple[Text, ...], Listed] = setting(
        'links, as segments from joint to joint and to task frames; ["*"] for all', ()
    )
    cables: Annotated[tuple[Text, ...], Listed] = setting(
        'muscles, as straight segments between via points; ["*"] for all', ()
    )
