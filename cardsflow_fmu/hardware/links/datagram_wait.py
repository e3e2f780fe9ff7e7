"""Waiting for a datagram: awake for a moment where one is about due, asleep for the rest.

Who sleeps must be woken, often on a core that sleeps as well and has forgotten everything about us:
some 10 to 40 µs, as long as a device on this machine takes for its answer. Who stays awake, and
looks again and again, has the datagram within 1 µs but keeps a core busy. So nobody does for long,
and nobody who has seen that it does not pay.
"""

from __future__ import annotations

import os
import select
import socket
import time
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

_LONGEST_PATIENCE = 100e-6
"""Nobody stays awake for longer, in [s]: a tenth of a core where a step takes 1 ms."""
_LEAST_PATIENCE = 10e-6
_PATIENCE = 3.0
"""How much longer than the wait before somebody stays awake."""
_SOON = 200e-6
"""What came asleep within such a time might have come sooner to someone awake, in [s]."""
_LONGEST_REST = 512
"""Waits that are slept through at most before the next one awake."""


class Waiter(Generic[T]):
    """Waits for what comes to a socket, one wait after the other.

    It stays awake if the datagram before came soon: a little longer than that took. If nothing has
    come by then, perhaps because the other side needs the very core that is kept busy, it sleeps,
    and sleeps through the next waits as well; twice as many each time, fewer after each success.

    Args:
        line: The socket, which does not block.
        read: Takes a datagram from it.
        cores: How many cores there are, for on one alone nobody stays awake; counted when None.
    """

    def __init__(
        self, line: socket.socket, read: Callable[[], T], cores: int | None = None
    ) -> None:
        self._readers, self._read = [line], read
        self._may_stay_awake = (_cores() if cores is None else cores) > 1
        self._is_awake = False
        self._patience = 0.0
        self._rest, self._next_rest = 0, 1

    def receive(self, until: float) -> T | None:
        """What came; None if nothing has by then. What is there already is always found.

        Args:
            until: On the system's monotonic clock, in [s].

        Raises:
            OSError: What the system has to tell of an earlier datagram: nobody listens there.
        """
        begin = time.perf_counter()
        if not self._is_awake:
            return self._receive_asleep(begin, until)
        remaining = until - time.monotonic()
        end = begin + min(self._patience, remaining)
        while True:
            try:
                came = self._read()
            except BlockingIOError:
                if time.perf_counter() >= end:
                    break
            else:
                self._next_rest = max(self._next_rest - 1, 1)
                self._expect(time.perf_counter() - begin)
                return came
        if remaining <= self._patience:
            return None
        self._is_awake = False
        self._rest, self._next_rest = self._next_rest, min(2 * self._next_rest, _LONGEST_REST)
        return self._receive_asleep(begin, until)

    def _receive_asleep(self, begin: float, until: float) -> T | None:
        while True:
            remaining = until - time.monotonic()
            if remaining > 0 and not select.select(self._readers, (), (), remaining)[0]:
                return None
            try:
                came = self._read()
            except BlockingIOError:  # it was damaged on its way, so that the system dropped it
                if remaining <= 0:
                    return None
            else:
                took = time.perf_counter() - begin
                if self._may_stay_awake and took < _SOON:
                    self._is_awake = self._rest == 0
                    self._rest = max(self._rest - 1, 0)
                    self._expect(took)
                return came

    def _expect(self, wait: float) -> None:
        """Take it that the next wait is about as long as one was, in [s]."""
        self._patience = min(_LEAST_PATIENCE + _PATIENCE * wait, _LONGEST_PATIENCE)


def _cores() -> int:
    """How many cores this thread may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
