"""Waits for datagrams: busy polling where an answer is about due, blocking otherwise.

A blocked thread wakes up 10 to 40 µs late, often on a core that sleeps as well: as long as a device
on this machine takes for its answer. Polling has the datagram within 1 µs but keeps a core busy. So
polling is bounded in time, and backs off if it has failed.
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
"""Longest polling in a wait, in [s]: a tenth of a core where a step takes 1 ms."""
_MIN_POLL = 10e-6
_POLL_FACTOR = 3.0
"""Ratio of polling to the wait before."""
_SOON = 200e-6
"""Longest blocking wait after which the next one may poll, in [s]."""
_MAX_BACKOFF = 512
"""Most blocking waits between two that poll."""


class AdaptiveReceiver(Generic[T]):
    """Receives from a socket, one wait after the other.

    A wait polls if the datagram before came soon: a little longer than that took. If nothing has
    come by then, perhaps because the other side needs the same core, it blocks, and so do the next
    waits; twice as many each time, fewer after each success.

    Args:
        line: The socket, which does not block.
        read: Reads a datagram from it.
        cores: Number of cores, as polling needs a second one; counted when None.
    """

    def __init__(
        self, line: socket.socket, read: Callable[[], T], cores: int | None = None
    ) -> None:
        self._readers, self._read = [line], read
        self._may_poll = (_cores() if cores is None else cores) > 1
        self._is_polling = False
        self._poll_time = 0.0
        self._blocking_left, self._backoff = 0, 1

    def receive(self, until: float) -> T | None:
        """Receive a datagram; None if there is none. One that is there already is always found.

        Args:
            until: On the system's monotonic clock, in [s].

        Raises:
            OSError: The system reports on an earlier datagram: there is no listener.
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
            except BlockingIOError:  # the system has dropped a damaged datagram
                if remaining <= 0:
                    return None
            else:
                took = time.perf_counter() - begin
                if self._may_poll and took < _SOON:
                    self._is_polling = self._blocking_left == 0
                    self._blocking_left = max(self._blocking_left - 1, 0)
                    self._set_poll_time(took)
                return datagram

    def _set_poll_time(self, wait: float) -> None:
        """Set the polling of the next wait from the length of one, in [s]."""
        self._poll_time = min(_MIN_POLL + _POLL_FACTOR * wait, _MAX_POLL)


def _cores() -> int:
    """Return number of cores that this thread may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
