"""Types of ROS 2 messages: those of the distribution Jazzy, and those in `interfaces/`."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

from cardsflow_fmu.utils.extras import require

JOINT_STATE = "sensor_msgs/msg/JointState"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
TEXT = "std_msgs/msg/String"
MARKERS = "visualization_msgs/msg/MarkerArray"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
TENDON_STATES = "cardsflow_msgs/msg/TendonStates"
TENDON_COMMANDS = "cardsflow_msgs/msg/TendonCommands"
TASK_STATES = "cardsflow_msgs/msg/TaskStates"
CONTROLLER_STATE = "cardsflow_msgs/msg/ControllerState"
SIGNALS = "cardsflow_msgs/msg/Signals"
ROBOY_TENDON = "roboy_simulation_msgs/msg/Tendon"

_INTERFACES = Path(__file__).with_name("interfaces")


def require_ros(key: str | None = None) -> None:
    """Refuse early what needs the extra `ros2`.

    Args:
        key: The option or setting that asks for it.

    Raises:
        InputError: A package of it is missing.
    """
    require("messages of ROS 2", "ros2", "mcap.writer", "rosbags.typesys", key=key)


@functools.cache
def type_store() -> Any:
    """The types, as a `Typestore` of the package rosbags.

    Raises:
        InputError: It is missing.
    """
    require_ros()
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    own: dict[str, Any] = {}
    for file in sorted(_INTERFACES.glob("*/msg/*.msg")):
        name = f"{file.parts[-3]}/msg/{file.stem}"
        own |= get_types_from_msg(file.read_text(encoding="utf-8"), name)
    store.register(own)
    return store


@functools.cache
def type_hash(name: str) -> str:
    """The hash of a type, such as `RIHS01_a13e...` (REP 2016)."""
    return str(type_store().hash_rihs01(name))


def definition(name: str) -> str:
    """The definition of a type with all that it is made of, as recordings hold it."""
    return str(type_store().generate_msgdef(name, ros_version=2)[0])
