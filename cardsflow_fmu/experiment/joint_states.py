"""Joint states in ROS 2 recordings: MCAP files, rosbag2 databases and folders."""

from __future__ import annotations

import contextlib
from array import array
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.message_types import require_ros, type_store
from cardsflow_fmu.utils.arrays import FloatArray

from .recorded_messages import TYPE, Budget, messages

RECORDINGS = (".mcap", ".db3")
TOPIC = "/joint_states"

_FOLDER_FILE = "metadata.yaml"
_MAX_PUBLISHERS = 1000


class JointStates(NamedTuple):
    """Joint states over time.

    Attributes:
        time: Shape (m,), in [s] after the first message, from the message headers.
        q: Positions, shape (m, n), in [rad] or [m].
        qd: Velocities, shape (m, n); None if not recorded.
    """

    names: tuple[str, ...]
    time: FloatArray
    q: FloatArray
    qd: FloatArray | None

    def columns(self) -> dict[str, FloatArray]:
        """Return the columns of a recorded motion, by name."""
        columns = {"time": self.time}
        columns |= {f"q.{name}": self.q[:, k] for k, name in enumerate(self.names)}
        if self.qd is not None:
            columns |= {f"qd.{name}": self.qd[:, k] for k, name in enumerate(self.names)}
        return columns


def is_recording(path: Path) -> bool:
    """Return whether a path is a ROS 2 recording, judged by its suffix, or a rosbag2 folder."""
    with contextlib.suppress(OSError, ValueError):
        if (path / _FOLDER_FILE).is_file():
            return True
    return path.suffix.lower() in RECORDINGS


def read_joint_states(path: Path, joints: Sequence[str] = ()) -> JointStates:
    """Read the joint states of a recording.

    The topic is `/joint_states`, or the only topic with such messages. If publishers have different
    joints, the first publisher with all `joints` is used.

    Args:
        path: A .mcap or .db3 file, or a rosbag2 folder.
        joints: Names of joints; empty for the first publisher.

    Raises:
        InputError: There are no joint states, a file is damaged, or a package of the extra `ros2`
            is missing.
    """
    files = [path] if path.is_file() else _recording_files(path)
    by_topic: dict[tuple[str, tuple[str, ...]], _Publisher] = defaultdict(_Publisher)
    require_ros()
    budget, store = Budget(), type_store()
    for file in files:
        try:
            for message in messages(file, budget):
                state = JointState.from_message(store.deserialize_cdr(message.content, TYPE))
                by_topic[message.topic, state.names].add(message.time_ns, state)
                if len(by_topic) > _MAX_PUBLISHERS:
                    raise InputError(f"has more than {_MAX_PUBLISHERS} sets of joints")
        except InputError as error:
            error.file = error.file or file
            raise
        except Exception as error:  # damaged files raise errors of any type
            problem = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"is damaged: {problem}"[:300], file=file) from None
    topics = sorted({topic for topic, _ in by_topic})
    if not topics:
        raise InputError(f"has no messages {TYPE}", file=path)
    if TOPIC not in topics and len(topics) > 1:
        problem = f"has joint states in {', '.join(topics)}, but not in {TOPIC}"
        raise InputError(problem, file=path)
    topic_used = TOPIC if TOPIC in topics else topics[0]
    publishers = {names: rows for (topic, names), rows in by_topic.items() if topic == topic_used}
    named = (names for names in publishers if names and set(joints) <= set(names))
    names = next(named, next(iter(publishers)))
    return publishers[names].states(names, path)


class _Publisher:
    """Joint states of one publisher; all messages have the same joints."""

    def __init__(self) -> None:
        self._stamps, self._recorded = array("q"), array("q")
        self._q, self._qd = _Rows("positions"), _Rows("velocities")

    def add(self, recorded_ns: int, state: JointState) -> None:
        """Add a message."""
        self._stamps.append(state.time_ns)
        self._recorded.append(recorded_ns)
        self._q.add(state.position)
        self._qd.add(state.velocity)

    def states(self, names: tuple[str, ...], path: Path) -> JointStates:
        """Return all rows sorted by header stamp, or by recording time without stamps."""
        times = np.array(self._stamps if any(self._stamps) else self._recorded)
        order = np.argsort(times, kind="stable")
        time, shape = times[order], (len(times), len(names))
        q = self._q.table(shape, path)[order]
        qd = self._qd.table(shape, path)[order] if self._qd.is_complete else None
        return JointStates(names, (time - time[0]) / 1e9, q, qd)


class _Rows:
    """Values of one quantity, row by row."""

    def __init__(self, quantity: str) -> None:
        self._quantity, self._numbers, self._widths = quantity, array("d"), set[int]()

    def add(self, row: FloatArray) -> None:
        """Add a row."""
        self._numbers.frombytes(row.astype(np.float64, copy=False).tobytes())
        self._widths.add(len(row))

    @property
    def is_complete(self) -> bool:
        """Whether every message has a row."""
        return 0 not in self._widths

    def table(self, shape: tuple[int, int], path: Path) -> FloatArray:
        """Return all rows as an array."""
        if self._widths != {shape[1]}:
            problem = f"its joint states must have one value of {self._quantity} per name"
            raise InputError(problem, file=path)
        return np.frombuffer(self._numbers).reshape(shape)


def _recording_files(folder: Path) -> list[Path]:
    """Return the files of a rosbag2 folder."""
    if not folder.is_dir():
        raise InputError("is neither a file nor a folder", file=folder)
    files = [file for file in folder.iterdir() if file.suffix.lower() in RECORDINGS]
    if not files:
        packed = [file.name for file in folder.iterdir() if file.suffix.lower() == ".zstd"]
        problem = f"its files are compressed, such as {packed[0]}" if packed else "no files"
        hint = (
            "convert it with `ros2 bag convert`"
            if packed
            else f"it must contain {' or '.join(RECORDINGS)}"
        )
        raise InputError(f"is an unsupported rosbag2 folder: {problem}; {hint}", file=folder)
    return sorted(files, key=lambda file: (len(file.name), file.name))
