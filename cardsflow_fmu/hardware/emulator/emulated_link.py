"""The link to an emulated robot in virtual time, as fast as it computes.

Both sides are complete but for sockets: session, link and frames on one; faulty line, device,
watchdog and robot on the other. Time passes only while the link waits, so that runs repeat exactly
and a controller takes no time.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Hashable

from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device
from cardsflow_fmu.hardware.links.framed_link import FramedLink

from .faults import FaultyLine

EMULATED = "emulated"
PEER = "link"
_BEGIN = 1.0
_AFTER = 1e-9
"""Time from a watchdog's deadline to its check, in [s]."""


class EmulatedWorld:
    """A clock, a device, and the line to it.

    Attributes:
        device: The device.
        line: The line.
        now: The time, in [s].
        answers: Frames from the device.
    """

    def __init__(self, device: Device, faults: Faults) -> None:
        self.device, self.line = device, FaultyLine(device, faults)
        self.now = _BEGIN
        self._steps = 0
        self.answers: deque[bytes] = deque()

    def monotonic(self) -> float:
        """Return the time, in [s]."""
        return self.now

    def monotonic_ns(self) -> int:
        """Return the time, in [ns]."""
        return int(self.now * 1e9)

    def sleep(self, seconds: float) -> None:
        """Let time pass, in [s]."""
        self.wait(self.now + seconds, lambda: False)

    def send(self, data: bytes) -> None:
        """Send a frame to the device."""
        self.line.send(data, PEER, self.now)
        self._process()

    def wait(self, until: float, is_over: Callable[[], object]) -> None:
        """Let time pass from one event to the next.

        Args:
            until: In [s].
            is_over: Whether to stop waiting.
        """
        while not is_over():
            event = min(self._next_event(), until)
            self.now = max(self.now, event)
            self._process()
            if event >= until:
                return

    def _next_event(self) -> float:
        deadline = self.device.next_deadline + _AFTER
        return min(self._next_step, self.line.next_due, deadline)

    @property
    def _next_step(self) -> float:
        """When the robot's next step ends; from a count, so that rounding does not add up."""
        return _BEGIN + (self._steps + 1) * self.device.step

    def _process(self) -> None:
        """Process all events that are due."""
        while self._next_step <= self.now:
            self.device.advance(self.device.step)
            self._steps += 1
        self.device.tick(self.now)
        for data, peer in self.line.due(self.now):
            self._deliver(data, peer)

    def _deliver(self, data: bytes, peer: Hashable) -> None:
        self.answers.append(data)


class EmulatedLink(FramedLink):
    """The link into an emulated world.

    Args:
        world: The world.
        key: The pre-shared key; unsigned frames when None.

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
