"""Results and recordings for tests, without a simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, muscle_signals
from cardsflow_fmu.simulation.result import SystemResult


def sinusoidal_result(robot: Robot, seconds: float = 2.0, step: float = 0.01) -> SystemResult:
    """Return a result with sinusoidal joint positions, and tensions within their limits."""
    time = np.arange(round(seconds / step) + 1) * step
    columns = {"time": time}
    for k, (name, c) in enumerate(
        zip(coordinate_signals("q", robot), robot.coordinates, strict=True)
    ):
        low, high = max(c.lower, -1.0), min(c.upper, 1.0)
        columns[name] = (low + high) / 2 + 0.4 * (high - low) * np.sin((1.0 + 0.3 * k) * time)
    for k, (name, m) in enumerate(zip(muscle_signals("f", robot), robot.muscles, strict=True)):
        part = 0.5 - 0.5 * np.cos((0.7 + 0.2 * k) * time)
        columns[name] = m.f_min + part * (min(m.f_max, 500.0) - m.f_min)
    rows = np.stack(list(columns.values()), axis=1)
    return SystemResult(tuple(columns), rows, {}, {"status": "complete"})


def with_columns(result: SystemResult, more: dict[str, np.ndarray]) -> SystemResult:
    """Return a result with additional columns."""
    rows = np.column_stack([result.rows, *more.values()])
    return SystemResult((*result.names, *more), rows, result.units, result.summary)


COUNT = 60
"""Number of messages of each publisher in `bag`."""


def joint_state(k: int, names: tuple[str, ...], begin: int = 1_700_000_000) -> Any:
    """Return message k of joint states at 1 kHz."""
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY).types
    time = types["builtin_interfaces/msg/Time"](sec=begin, nanosec=k * 1_000_000)
    return types["sensor_msgs/msg/JointState"](
        header=types["std_msgs/msg/Header"](stamp=time, frame_id=""),
        name=list(names),
        position=np.sin(0.01 * k + np.arange(len(names))),
        velocity=np.cos(0.01 * k + np.arange(len(names))),
        effort=np.zeros(0),
    )


def write_bag(folder: Path, *publishers: tuple[str, tuple[str, ...]], mcap: bool = True) -> Path:
    """Write a rosbag2 folder with rosbags, from topics and the names of their joints."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store, kind = get_typestore(Stores.ROS2_JAZZY), "sensor_msgs/msg/JointState"
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        topics = {
            t: writer.add_connection(t, kind, typestore=store) for t, _ in dict(publishers).items()
        }
        for k in range(COUNT):
            for topic, names in publishers:
                content = store.serialize_cdr(joint_state(k, names), kind)
                writer.write(topics[topic], 1_700_000_000_000_000_000 + k, content)
    return folder
