"""Types of ROS 2 messages; those of recordings by the package rosbags."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

from cardsflow_fmu.utils.extras import require

JOINT_STATE = "sensor_msgs/msg/JointState"
COMMANDS = "std_msgs/msg/Float64MultiArray"
CLOCK = "rosgraph_msgs/msg/Clock"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
TEXT = "std_msgs/msg/String"
MARKERS = "visualization_msgs/msg/MarkerArray"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
SIGNALS = "cardsflow_msgs/msg/Signals"

_SIGNALS = Path(__file__).parent / "interfaces/cardsflow_msgs/msg/Signals.msg"


def require_ros(key: str | None = None) -> None:
    """Reject early what needs the extra `ros2`.

    Args:
        key: The option or setting that asks for it.

    Raises:
        InputError: A package of it is missing.
    """
    require("recordings of ROS 2", "ros2", "mcap.writer", "rosbags.typesys", key=key)


@functools.cache
def type_store() -> Any:
    """Return the message types of Jazzy and our own, as a `Typestore` of the package rosbags.

    Raises:
        InputError: It is missing.
    """
    require_ros()
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(_SIGNALS.read_text(encoding="utf-8"), SIGNALS))
    return store
