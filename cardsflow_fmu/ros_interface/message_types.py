"""Names of ROS 2 message types, and their definitions for recordings."""

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
    """Check that the packages of the extra `ros2` are installed."""
    require("recordings of ROS 2", "ros2", "mcap.writer", "rosbags.typesys", key=key)


@functools.cache
def type_store() -> Any:
    """Return the message types of ROS 2 Jazzy and cardsflow_msgs, as a `Typestore` of rosbags."""
    require_ros()
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(_SIGNALS.read_text(encoding="utf-8"), SIGNALS))
    return store
