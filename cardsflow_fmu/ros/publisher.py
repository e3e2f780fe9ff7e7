"""A run in progress as topics of a node: what is newest, at an even rate."""

from __future__ import annotations

import contextlib
import math
import sys
import threading
from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.cosim.recording import Watch
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.middleware.address import NodeAddress
from cardsflow_fmu.middleware.cdr import message_rows, stamp
from cardsflow_fmu.middleware.node import Node, Topic
from cardsflow_fmu.middleware.open_node import open_node
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.utils.arrays import FloatArray

from .scene_topics import RATE, SceneTopics, Shown
from .topics import Batch, RowTopics, nanoseconds

CLOCK = Topic("/clock", "rosgraph_msgs/msg/Clock")

_SWITCH_INTERVAL = 1e-4
"""Longest time that the run waits for the publisher to let Python go, in [s]."""


@contextlib.contextmanager
def published(experiment: Experiment, address: NodeAddress) -> Iterator[Watch]:
    """A function that publishes a run in progress, for `run(..., watch=...)`.

    A thread sends the newest row 50 times a second; what no subscriber takes is gone.

    Args:
        experiment: The experiment of the run.
        address: The node.

    Raises:
        InputError: A package of its extra is missing, or its middleware cannot be reached.
        SimulationError: At the end: publishing ended before the run.
    """
    with open_node(address) as node, quick_switches():
        publisher = RunPublisher(Shown.of(experiment), node)
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


@contextlib.contextmanager
def quick_switches() -> Iterator[None]:
    """Threads let each other go on sooner than Python has it by default."""
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

    Attributes:
        failure: What ended publishing; None while all is well.
    """

    def __init__(self, shown: Shown, node: Node, *, has_clock: bool = True) -> None:
        self.failure: Exception | None = None
        self._node, self._scene = node, SceneTopics(shown)
        self._robot, self._has_clock = shown.robot, has_clock
        self._newest: RunData | None = None
        self._sent = -math.inf
        self._highest = 0.0
        self._rows: RowTopics | None = None
        self._stop = threading.Event()
        for topic in (*([CLOCK] if has_clock else []), *self._scene.topics):
            node.advertise(topic)
        self._send(self._scene.first(0))

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
            for topic in self._rows.topics:
                self._node.advertise(topic)
        time_ns = nanoseconds(last["time"])
        if self._has_clock:
            clock = message_rows(CLOCK.type, {"clock": stamp(time_ns)}, 1)
            self._send([Batch(CLOCK, time_ns, clock)])
        self._rows.replace(last)
        self._send(self._rows.batches(0, 1))
        frame = self._scene.frame_rows(last)
        self._highest = max(self._highest, self._scene.highest(last, frame))
        self._send(self._scene.batches(last, frame, self._highest))

    def _send(self, batches: Iterator[Batch] | list[Batch]) -> None:
        for batch in batches:
            for row in np.asarray(batch.rows):
                self._node.publish(batch.topic, row.tobytes())
