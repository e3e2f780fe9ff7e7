"""Link to an emulated robot in virtual time, which runs as fast as the computer allows.

Except for sockets, both sides are complete: session, link and frames on the controller side;
faulty line, device, watchdog and robot on the device side. Virtual time advances only while the
link waits. Therefore runs are repeatable, and the controller's computing time is zero.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.links.framed_link import FramedLink

from .faults import FaultyLine

EMULATED = "emulated"
PEER = "link"
_START_TIME = 1.0
_CHECK_DELAY = 1e-9
"""Delay of the watchdog check after the watchdog's deadline, in [s]."""


class EmulatedWorld:
    """Virtual clock, device, and the line to the device.

    Attributes:
        now: Virtual time, in [s].
        answers: Frames from the device that the link has not received yet.
    """

    def __init__(self, device: Device, faults: Faults) -> None:
        self.device, self.line = device, FaultyLine(device, faults)
        self.now = _START_TIME
        self._steps = 0
        self.answers: deque[bytes] = deque()

    def monotonic(self) -> float:
        """Return the virtual time, in [s]."""
        return self.now

    def monotonic_ns(self) -> int:
        """Return the virtual time, in [ns]."""
        return int(self.now * 1e9)

    def sleep(self, seconds: float) -> None:
        """Advance the virtual time, in [s]."""
        self.wait(self.now + seconds, lambda: False)

    def send(self, data: bytes) -> None:
        """Send a frame to the device."""
        self.line.send(data, PEER, self.now)
        self._process()

    def wait(self, until: float, is_over: Callable[[], object]) -> None:
        """Advance the virtual time from event to event.

        Args:
            until: Time at which the wait ends, in [s].
            is_over: Function that returns whether to end the wait early.
        """
        while not is_over():
            event = min(self._next_event(), until)
            self.now = max(self.now, event)
            self._process()
            if event >= until:
                return

    def _next_event(self) -> float:
        deadline = self.device.next_deadline + _CHECK_DELAY
        return min(self._next_step, self.line.next_due, deadline)

    @property
    def _next_step(self) -> float:
        """End of the robot's next step, computed from a count to avoid accumulated rounding."""
        return _START_TIME + (self._steps + 1) * self.device.step

    def _process(self) -> None:
        """Process all events that are due."""
        while self._next_step <= self.now:
            self.device.advance(self.device.step)
            self._steps += 1
        self.device.tick(self.now)
        self.answers += [data for data, _ in self.line.due(self.now)]


class EmulatedLink(FramedLink):
    """Link to the device of an `EmulatedWorld`.

    Raises:
        InputError: The key is too short.
    """

    def __init__(self, world: EmulatedWorld, *, key: bytes | None = None) -> None:
        super().__init__(f"{EMULATED}:", key=key, clock=world)
        self._world = world

    def _connect(self) -> None:
        self._world.answers.clear()

    def _disconnect(self) -> None:
        pass

    def _send(self, data: bytes) -> None:
        self._world.send(data)
        self.counters["sent"] += 1

    def _receive(self, deadline: float) -> bytes | None:
        answers = self._world.answers
        if not answers:
            self._world.wait(deadline, lambda: answers)
        return answers.popleft() if answers else None
