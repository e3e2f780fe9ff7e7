"""A run in progress as topics of a node: what is newest, at an even rate."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.cosim.recording import Watch
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.ros_interface import message_types as types
from cardsflow_fmu.ros_interface.address import NodeAddress
from cardsflow_fmu.ros_interface.node import Node, Topic, stamp
from cardsflow_fmu.ros_interface.rclpy_node import Parameter, open_node
from cardsflow_fmu.utils.arrays import FloatArray

from .scene_topics import RATE, SceneTopics, Shown
from .topics import SIGNALS, Batch, RowTopics, nanoseconds

CLOCK = Topic("/clock", types.CLOCK)

_PARAMETERS = {bool, int, float, str}
_SWITCH_INTERVAL = 1e-4
"""Longest time that the run waits for the publisher to let Python go, in [s]."""


@contextlib.contextmanager
def published(
    experiment: Experiment, address: NodeAddress, report: Callable[[str], object]
) -> Iterator[Watch]:
    """A function that publishes a run in progress, for `run(..., watch=...)`.

    A thread sends the newest row 50 times a second; what no subscriber takes is gone.

    Args:
        experiment: The experiment of the run.
        address: The node.
        report: Takes a line for people.

    Raises:
        InputError: This Python has no rclpy, or its middleware cannot be started.
        SimulationError: At the end: publishing ended before the run.
    """
    with open_node(address, parameters_of(experiment)) as node, quick_switches():
        publisher = RunPublisher(Shown.of(experiment), node)
        report(f"published as node {address}{publisher.remark}")
        thread = threading.Thread(target=publisher.run, name="ros2", daemon=True)
        thread.start()
        try:
            yield publisher.watch
        finally:
            publisher.stop()
            thread.join()
    if publisher.failure is not None:
        reason = " ".join(str(publisher.failure).split()) or type(publisher.failure).__name__
        raise SimulationError(f"publishing ended early, the run did not: {reason}")


def parameters_of(experiment: Experiment) -> dict[str, Parameter]:
    """Settings of controller and run as parameters of a node, such as `controller.kp`."""
    tables = {"controller": experiment.controller.data(), "run": experiment.run.data()}
    return {
        f"{table}.{key}": value
        for table, values in tables.items()
        for key, value in values.items()
        if _is_parameter(value)
    }


def _is_parameter(value: object) -> bool:
    """Return whether ROS has parameters of such a value: one of them, or a list of one kind."""
    if isinstance(value, list):
        kinds = {type(element) for element in value}
        return len(kinds) == 1 and kinds <= _PARAMETERS
    return type(value) in _PARAMETERS


@contextlib.contextmanager
def quick_switches() -> Iterator[None]:
    """Threads let each other continue sooner than Python has it by default."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(min(before, _SWITCH_INTERVAL))
    try:
        yield
    finally:
        sys.setswitchinterval(before)


class RunPublisher:
    """Publishes the newest row of a run.

    Args:
        shown: The robot of the run.
        node: The node.
        has_clock: Whether the time of the run is published as that of ROS.
        without: Topics that another publishes.

    Attributes:
        failure: What ended publishing; None while all is well.
        remark: Which topics are left out because this ROS lacks their messages, to end a line.
    """

    def __init__(
        self, shown: Shown, node: Node, *, has_clock: bool = True, without: Collection[str] = ()
    ) -> None:
        self.failure: Exception | None = None
        self._node, self._scene = node, SceneTopics(shown)
        self._robot, self._has_clock = shown.robot, has_clock
        self._newest: RunData | None = None
        self._sent = -math.inf
        self._highest = 0.0
        self._rows: RowTopics | None = None
        self._stop = threading.Event()
        topics = (*([CLOCK] if has_clock else []), *self._scene.topics)
        missing = [topic for topic in (*topics, SIGNALS) if not node.knows(topic.type)]
        self._left_out = {topic.name for topic in missing} | set(without)
        packages = ", ".join(f"{t.name} ({t.type.partition('/')[0]})" for t in missing)
        self.remark = f", without {packages}: not in this ROS 2" if missing else ""
        self._advertise(topics)
        self._send(self._scene.first(np.zeros(1)))

    def watch(self, names: tuple[str, ...], rows: FloatArray) -> None:
        """Take note of the rows so far; costs the run next to nothing."""
        self._newest = RunData(names, rows, {}, {})

    def run(self) -> None:
        """Publish until `stop`, and then the last row."""
        try:
            while not self._stop.wait(1.0 / RATE):
                self.send_newest()
            self.send_newest()
        except Exception as error:  # of a thread: reported at the end of the run
            self.failure = error

    def stop(self) -> None:
        """Let `run` end."""
        self._stop.set()

    def send_newest(self) -> None:
        """Publish the newest row, unless that is done."""
        run = self._newest
        if run is None or not len(run.rows):
            return
        last = RunData(run.names, run.rows[-1:], run.units, run.summary)
        if last["time"][0] == self._sent:
            return
        self._sent = last["time"][0]
        if self._rows is None:
            self._rows = RowTopics(last, self._robot)
            self._advertise(self._rows.topics)
        if self._has_clock:
            time_ns = nanoseconds(last["time"])
            self._send([Batch(CLOCK, time_ns, {"clock": stamp(time_ns)})])
        self._rows.replace(last)
        self._send(self._rows.batches(0, 1))
        frame = self._scene.frame_rows(last)
        self._highest = max(self._highest, self._scene.highest(last, frame))
        self._send(self._scene.batches(last, frame, self._highest))

    def _advertise(self, topics: Iterable[Topic]) -> None:
        for topic in topics:
            if topic.name not in self._left_out:
                self._node.advertise(topic)

    def _send(self, batches: Iterable[Batch]) -> None:
        for batch in batches:
            if batch.topic.name not in self._left_out:
                self._node.publish(batch.topic, _only(batch.values))


def _only(values: Any) -> Any:
    """Return the fields of the only message of a batch."""
    if isinstance(values, np.ndarray):
        (row,) = values
        return row if row.ndim else row.item()
    if isinstance(values, Mapping):
        return {name: _only(value) for name, value in values.items()}
    return [_only(value) for value in values] if isinstance(values, list) else values
