"""Faults of a communication line: loss, delay, reordering, duplication, damage, outages.

Times are arguments, so that tests need not wait. Equal seeds, frames and times result in equal
faults.
"""

from __future__ import annotations

import heapq
import math
import random
from collections import Counter
from collections.abc import Hashable

from cardsflow_fmu.experiment.settings.hardware import Faults
from cardsflow_fmu.hardware.device.device import Device

_MAX_DAMAGED_BYTES = 8
_RESIZED_FRACTION = 0.2
"""Fraction of the damaged frames whose length changes. In the other ones, bytes change."""
_MAX_HOLD_TIME = 0.01
"""Maximum time for which a frame is delayed so that a later frame arrives first, in [s]."""


class FaultyChannel:
    """One direction of a line.

    Args:
        faults: Probabilities and times of the faults.
        direction: Name of the direction. It is part of the seed, so that directions differ.

    Attributes:
        counters: Number of frames sent, delivered, lost, duplicated, overtaken, damaged.
    """

    def __init__(self, faults: Faults, direction: str = "") -> None:
        self._faults = faults
        self._random = random.Random(f"{faults.seed} {direction}")
        self._waiting: list[tuple[float, int, bytes, Hashable]] = []
        self._held_frame: tuple[float, bytes, Hashable] | None = None
        self._order = 0
        self._first: float | None = None
        self.counters: Counter[str] = Counter(
            dict.fromkeys(("sent", "delivered", "lost", "duplicated", "overtaken", "damaged"), 0)
        )

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame to or from a peer, at the time `now`, in [s]."""
        faults, chance = self._faults, self._random.random
        self.counters["sent"] += 1
        if self._first is None:
            self._first = now
        if self._is_out(now - self._first) or chance() < faults.loss:
            self.counters["lost"] += 1
            return
        if chance() < faults.corrupt:
            self.counters["damaged"] += 1
            data = self._damage(data)
        if self._held_frame is None and chance() < faults.reorder:
            self.counters["overtaken"] += 1
            self._held_frame = (now, data, peer)
            return
        arrival = self._schedule(data, peer, now)
        if chance() < faults.duplicate:
            self.counters["duplicated"] += 1
            self._schedule(data, peer, now)
        self._release(arrival)

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Return the frames that have arrived by now, with their peers, in order of arrival."""
        if self._held_frame is not None and now >= self._held_frame[0] + _MAX_HOLD_TIME:
            self._release(self._held_frame[0] + _MAX_HOLD_TIME)
        frames = []
        while self._waiting and self._waiting[0][0] <= now:
            _, _, data, peer = heapq.heappop(self._waiting)
            frames.append((data, peer))
        self.counters["delivered"] += len(frames)
        return frames

    @property
    def next_due(self) -> float:
        """Arrival time of the next frame, in [s], or infinity if no frame is on the line."""
        release = math.inf if self._held_frame is None else self._held_frame[0] + _MAX_HOLD_TIME
        return min(release, self._waiting[0][0] if self._waiting else math.inf)

    def _is_out(self, time: float) -> bool:
        return any(begin <= time < begin + length for begin, length in self._faults.outages)

    def _schedule(self, data: bytes, peer: Hashable, now: float) -> float:
        """Schedule the arrival of a frame. Return the arrival time, in [s]."""
        arrival = now + self._faults.delay + self._faults.jitter * self._random.random()
        self._enqueue(arrival, data, peer)
        return arrival

    def _enqueue(self, arrival: float, data: bytes, peer: Hashable) -> None:
        self._order += 1
        heapq.heappush(self._waiting, (arrival, self._order, data, peer))

    def _release(self, arrival: float) -> None:
        """Schedule the delayed frame, if there is one, after other frames with this arrival."""
        if self._held_frame is not None:
            _, data, peer = self._held_frame
            self._held_frame = None
            self._enqueue(arrival, data, peer)

    def _damage(self, data: bytes) -> bytes:
        """Return the frame with changed bytes or a changed length."""
        choose = self._random
        if not data or choose.random() < _RESIZED_FRACTION:
            length = choose.choice([k for k in range(len(data) + 9) if k != len(data)])
            return (data + choose.randbytes(8))[:length]
        changed = bytearray(data)
        indices = choose.sample(range(len(data)), min(_MAX_DAMAGED_BYTES, len(data)))
        for index in indices[: choose.randint(1, len(indices))]:
            changed[index] ^= choose.randint(1, 255)
        return bytes(changed)


class FaultyLine:
    """Two-way line to a device, with faults in both directions.

    Attributes:
        inward, outward: Directions to the device and from the device.
    """

    def __init__(self, device: Device, faults: Faults) -> None:
        self._device = device
        self.inward = FaultyChannel(faults, "inward")
        self.outward = FaultyChannel(faults, "outward")

    def send(self, data: bytes, peer: Hashable, now: float) -> None:
        """Send a frame of a peer to the device, at the time `now`, in [s]."""
        self.inward.send(data, peer, now)

    def due(self, now: float) -> list[tuple[bytes, Hashable]]:
        """Deliver arrived frames to the device. Return arrived answers, with their peers."""
        for data, peer in self.inward.due(now):
            for answer in self._device.receive(data, peer, now):
                self.outward.send(answer, peer, now)
        return self.outward.due(now)

    @property
    def next_due(self) -> float:
        """Arrival time of the next frame in either direction, in [s], or infinity."""
        return min(self.inward.next_due, self.outward.next_due)

    @property
    def counters(self) -> dict[str, dict[str, int]]:
        """Counters of both directions."""
        return {"inward": dict(self.inward.counters), "outward": dict(self.outward.counters)}
