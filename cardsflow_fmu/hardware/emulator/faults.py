"""Faults of a line: loss, delay, reordering, duplication, damage, outages.

Times are arguments, so that tests need not wait. The same seed and the same frames at the same
times give the same faults.
"""

from __future__ import annotations

import heapq
import math
import random
from collections import Counter
from collections.abc import Hashable
from typing import Protocol

from cardsflow_fmu.experiment.settings.hardware import Faults

_MAX_DAMAGED_BYTES = 8
_RESIZED = 0.2
"""Part of the damaged frames that are cut or lengthened instead of having bytes changed."""
_MAX_HELD = 0.01
"""Longest time that a frame waits to be overtaken, in [s]."""


class FaultyChannel:
    """One direction of a line.

    Args:
        faults: The faults.
        direction: Name of the direction, which has random numbers of its own.

    Attributes:
        counters: Number of frames sent, delivered, lost, duplicated, overtaken, damaged.
    """

    def __init__(self, faults: Faults, direction: str = "") -> None:
        self._faults = faults
        self._random = random.Random(f"{faults.seed} {direction}")
        self._waiting: list[tuple[float, int, bytes, Hashable]] = []
        self._held: tuple[float, bytes, Hashable] | None = None
        self._order = 0
        self._first: float | None = None
        self.counters: Counter[str] = Counter(
            dict.fromkeys(("sent", "delivered", "lost", "duplicated", "overtaken", "damaged"), 0)
        )

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame.

        Args:
            data: The frame.
            peer: Where it comes from or goes to.
            now: In [s].
        """
        faults, chance = self._faults, self._random.random
        self.counters["sent"] += 1
        if self._first is None:
            self._first = now
        if self._is_out(now - self._first) or chance() < faults.loss:
            self.counters["lost"] += 1
            return
        if chance() < faults.corrupt:
            self.counters["damaged"] += 1
            data = self._damaged(data)
        if self._held is None and chance() < faults.reorder:
            self.counters["overtaken"] += 1
            self._held = (now, data, peer)
            return
        arrival = self._send_on(data, peer, now)
        if chance() < faults.duplicate:
            self.counters["duplicated"] += 1
            self._send_on(data, peer, now)
        self._release(arrival)

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Return the frames due until now, with their peers, in the order of arrival.

        Args:
            now: In [s].
        """
        if self._held is not None and now >= self._held[0] + _MAX_HELD:
            self._release(self._held[0] + _MAX_HELD)
        frames = []
        while self._waiting and self._waiting[0][0] <= now:
            _, _, data, peer = heapq.heappop(self._waiting)
            frames.append((data, peer))
        self.counters["delivered"] += len(frames)
        return frames

    @property
    def next_due(self) -> float:
        """When the next frame arrives, in [s]; infinite if there is none."""
        held = math.inf if self._held is None else self._held[0] + _MAX_HELD
        return min(held, self._waiting[0][0] if self._waiting else math.inf)

    def _is_out(self, time: float) -> bool:
        return any(begin <= time < begin + length for begin, length in self._faults.outages)

    def _send_on(self, data: bytes, peer: Hashable, now: float) -> float:
        """Schedule a frame; returns when it arrives."""
        arrival = now + self._faults.delay + self._faults.jitter * self._random.random()
        self._arrive(arrival, data, peer)
        return arrival

    def _arrive(self, arrival: float, data: bytes, peer: Hashable) -> None:
        self._order += 1
        heapq.heappush(self._waiting, (arrival, self._order, data, peer))

    def _release(self, arrival: float) -> None:
        """Let the frame that was held back arrive right behind another."""
        if self._held is not None:
            _, data, peer = self._held
            self._held = None
            self._arrive(arrival, data, peer)

    def _damaged(self, data: bytes) -> bytes:
        """Return the frame with other bytes, or another length; never the frame itself."""
        choose = self._random
        if not data or choose.random() < _RESIZED:
            length = choose.choice([k for k in range(len(data) + 9) if k != len(data)])
            return (data + choose.randbytes(8))[:length]
        changed = bytearray(data)
        indices = choose.sample(range(len(data)), min(_MAX_DAMAGED_BYTES, len(data)))
        for index in indices[: choose.randint(1, len(indices))]:
            changed[index] ^= choose.randint(1, 255)
        return bytes(changed)


class Receiver(Protocol):
    """The receiver of frames, such as a `Device`."""

    def receive(self, data: bytes, peer: Hashable, now: float) -> list[bytes]:
        """Process a frame; returns the answers, for the same peer."""


class FaultyLine:
    """A line to a device and back, with faults in both directions.

    Attributes:
        inward, outward: The two directions.
    """

    def __init__(self, device: Receiver, faults: Faults) -> None:
        self._device = device
        self.inward = FaultyChannel(faults, "inward")
        self.outward = FaultyChannel(faults, "outward")

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame towards the device.

        Args:
            data: The frame.
            peer: Its sender.
            now: In [s].
        """
        self.inward.send(data, peer, now)

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Deliver the frames due until now to the device; returns the answers due, with peers.

        Args:
            now: In [s].
        """
        for data, peer in self.inward.due(now):
            for answer in self._device.receive(data, peer, now):
                self.outward.send(answer, peer, now)
        return self.outward.due(now)

    @property
    def next_due(self) -> float:
        """When the next frame is due in either direction, in [s]; infinite if there is none."""
        return min(self.inward.next_due, self.outward.next_due)

    @property
    def counters(self) -> dict[str, dict[str, int]]:
        """The counters of both directions."""
        return {"inward": dict(self.inward.counters), "outward": dict(self.outward.counters)}
