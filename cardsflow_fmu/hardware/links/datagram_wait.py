"""Waits for datagrams: busy polling when an answer is expected soon, blocking otherwise.

A blocked thread wakes up 10 to 40 µs late, since its core often sleeps too. A device on the same
machine needs about as long to answer. Polling receives a datagram within 1 µs but occupies a core.
Therefore the polling time is limited, and the receiver polls less often after unsuccessful polling.
"""

from __future__ import annotations

import os
import select
import socket
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

_MAX_POLL = 100e-6
"""Maximum polling time of a wait, in [s]: 10 % of a core with a time step of 1 ms."""
_MIN_POLL = 10e-6
"""Minimum polling time of a wait, in [s]."""
_POLL_FACTOR = 3.0
"""Ratio of the polling time to the duration of the previous wait."""
_MAX_SHORT_WAIT = 200e-6
"""Maximum duration of a blocking wait after which the next wait may poll, in [s]."""
_MAX_BACKOFF = 512
"""Maximum number of blocking waits between two waits that poll."""


class AdaptiveReceiver(Generic[T]):
    """Receiver of datagrams from a socket that chooses between polling and blocking.

    If the previous datagram arrived soon, the next wait polls a little longer than that wait. If no
    datagram arrives in this time, the wait blocks: the other side may need the same core. The
    following waits block too. Their number doubles with each failure and decreases with each
    success.

    Args:
        read: Function that reads a datagram from the socket.
        cores: Number of available cores, or None to determine it. Polling requires at least two.
    """

    def __init__(
        self, line: socket.socket, read: Callable[[], T], cores: int | None = None
    ) -> None:
        self._readers, self._read = [line], read
        self._may_poll = (_available_cores() if cores is None else cores) > 1
        self._is_polling = False
        self._poll_time = 0.0
        self._blocking_left, self._backoff = 0, 1

    def receive(self, until: float) -> T | None:
        """Return the next datagram, or None if no datagram arrives in time.

        A datagram that has already arrived is returned even after the deadline.

        Args:
            until: Deadline on the system's monotonic clock, in [s].

        Raises:
            OSError: The system reports that an earlier datagram had no receiver.
        """
        begin = time.perf_counter()
        if not self._is_polling:
            return self._receive_blocking(begin, until)
        remaining = until - time.monotonic()
        end = begin + min(self._poll_time, remaining)
        while True:
            try:
                datagram = self._read()
            except BlockingIOError:
                if time.perf_counter() >= end:
                    break
            else:
                self._backoff = max(self._backoff - 1, 1)
                self._set_poll_time(time.perf_counter() - begin)
                return datagram
        if remaining <= self._poll_time:
            return None
        self._is_polling = False
        self._blocking_left, self._backoff = self._backoff, min(2 * self._backoff, _MAX_BACKOFF)
        return self._receive_blocking(begin, until)

    def _receive_blocking(self, begin: float, until: float) -> T | None:
        while True:
            remaining = until - time.monotonic()
            if remaining > 0 and not select.select(self._readers, (), (), remaining)[0]:
                return None
            try:
                datagram = self._read()
            except BlockingIOError:  # the system has dropped a damaged datagram after `select`
                if remaining <= 0:
                    return None
            else:
                took = time.perf_counter() - begin
                if self._may_poll and took < _MAX_SHORT_WAIT:
                    self._is_polling = self._blocking_left == 0
                    self._blocking_left = max(self._blocking_left - 1, 0)
                    self._set_poll_time(took)
                return datagram

    def _set_poll_time(self, wait: float) -> None:
        """Set the polling time of the next wait from the duration of this wait, in [s]."""
        self._poll_time = min(_MIN_POLL + _POLL_FACTOR * wait, _MAX_POLL)


def _available_cores() -> int:
    """Return the number of cores that this thread may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
