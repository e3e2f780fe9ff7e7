"""Publisher of a run in progress: the newest values at a fixed rate."""

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

from .scene_topics import RATE, SceneTopics, ShownRobot
from .topics import SIGNALS, Batch, RowTopics, nanoseconds

CLOCK = Topic("/clock", types.CLOCK)

_PARAMETERS = {bool, int, float, str}
_SWITCH_INTERVAL = 1e-4
"""Maximum time for which the publisher thread holds Python's lock, in [s]."""


@contextlib.contextmanager
def published(
    experiment: Experiment, address: NodeAddress, report: Callable[[str], object]
) -> Iterator[Watch]:
    """Open a node and return a function that publishes a run, for `run(..., watch=...)`.

    A thread publishes the newest row at 50 Hz.

    Args:
        report: Function that is called with a line of text about the node.

    Raises:
        InputError: This Python has no rclpy, or the middleware cannot be started.
        SimulationError: Publishing failed before the run ended. It is raised at the end.
    """
    with open_node(address, node_parameters(experiment)) as node, short_switch_interval():
        publisher = RunPublisher(ShownRobot.from_experiment(experiment), node)
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
        raise SimulationError(f"publishing failed before the end of the run: {reason}")


def node_parameters(experiment: Experiment) -> dict[str, Parameter]:
    """Return the settings of controller and run as node parameters, such as `controller.kp`."""
    tables = {"controller": experiment.controller.data(), "run": experiment.run.data()}
    return {
        f"{table}.{key}": value
        for table, values in tables.items()
        for key, value in values.items()
        if _is_parameter(value)
    }


def _is_parameter(value: object) -> bool:
    """Return whether ROS supports the value as a parameter: a scalar, or a list of one type."""
    if isinstance(value, list):
        kinds = {type(element) for element in value}
        return len(kinds) == 1 and kinds <= _PARAMETERS
    return type(value) in _PARAMETERS


@contextlib.contextmanager
def short_switch_interval() -> Iterator[None]:
    """Reduce the interval at which Python switches threads, as a context."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(min(before, _SWITCH_INTERVAL))
    try:
        yield
    finally:
        sys.setswitchinterval(before)


class RunPublisher:
    """Publisher of the newest row of a run.

    Args:
        has_clock: Whether the time of the run is published on `/clock`.
        without: Names of topics that another object publishes.

    Attributes:
        failure: Exception that ended publishing, or None.
        remark: Text about topics whose message types are not installed, to append to a line.
    """

    def __init__(
        self,
        shown: ShownRobot,
        node: Node,
        *,
        has_clock: bool = True,
        without: Collection[str] = (),
    ) -> None:
        self.failure: Exception | None = None
        self._node, self._scene = node, SceneTopics(shown)
        self._robot, self._has_clock = shown.robot, has_clock
        self._newest: RunData | None = None
        self._sent = -math.inf
        self._max_tension = 0.0
        self._rows: RowTopics | None = None
        self._stop = threading.Event()
        topics = (*([CLOCK] if has_clock else []), *self._scene.topics)
        missing = [topic for topic in (*topics, SIGNALS) if not node.has_type(topic.type)]
        self._omitted = {topic.name for topic in missing} | set(without)
        packages = ", ".join(f"{t.name} ({t.type.partition('/')[0]})" for t in missing)
        self.remark = f", without {packages}: not installed in this ROS 2" if missing else ""
        self._advertise(topics)
        self._send(self._scene.first(np.zeros(1)))

    def watch(self, names: tuple[str, ...], rows: FloatArray) -> None:
        """Store a reference to the rows so far, for the publishing thread."""
        self._newest = RunData(names, rows, {}, {})

    def run(self) -> None:
        """Publish rows until `stop` is called, then publish the last row."""
        try:
            while not self._stop.wait(1.0 / RATE):
                self.send_newest()
            self.send_newest()
        except Exception as error:  # runs in a thread: reported at the end of the run
            self.failure = error

    def stop(self) -> None:
        """End `run`."""
        self._stop.set()

    def send_newest(self) -> None:
        """Publish the newest row if it has not been published yet."""
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
        self._max_tension = max(self._max_tension, self._scene.max_tension(last, frame))
        self._send(self._scene.batches(last, frame, self._max_tension))

    def _advertise(self, topics: Iterable[Topic]) -> None:
        for topic in topics:
            if topic.name not in self._omitted:
                self._node.advertise(topic)

    def _send(self, batches: Iterable[Batch]) -> None:
        for batch in batches:
            if batch.topic.name not in self._omitted:
                self._node.publish(batch.topic, _single_message(batch.values))


def _single_message(values: Any) -> Any:
    """Return the fields of the message in a batch of one message."""
    if isinstance(values, np.ndarray):
        (row,) = values
        return row if row.ndim else row.item()
    if isinstance(values, Mapping):
        return {name: _single_message(value) for name, value in values.items()}
    return [_single_message(value) for value in values] if isinstance(values, list) else values
