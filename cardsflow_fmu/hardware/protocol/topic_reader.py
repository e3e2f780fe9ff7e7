"""Checks of messages on a topic, which has neither handshake nor signature.

A message is valid if

- it contains all required names (and, for commands, no other names),
- it contains a finite number for each name,
- its time stamp is newer than the time stamp of the previous message,
- its delay is not too long, and
- the topic has one publisher, which is also the publisher of the first message.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping

import numpy as np

from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.node import Received
from cardsflow_fmu.utils.arrays import FloatArray

_MAX_CLOCK_DRIFT = 1e-3
"""Maximum relative drift between two clocks. A larger drift is treated as a growing delay."""

REASONS = {
    "names": "messages have wrong names",
    "count": "messages do not contain numbers for all names",
    "not finite": "messages contain numbers that are not finite",
    "several": "several nodes publish: all their messages are dropped",
    "publisher": "another node publishes now: its messages are dropped",
    "stale": "messages have time stamps that are not newer than the previous time stamp",
    "old": "messages arrive too late",
    "ended": "messages come from a node whose commands have ended: restart the node",
}


class TopicReader:
    """Reader and checker of the messages of a topic.

    The clocks of both sides may differ: the delay of a message is relative to the fastest message.

    Args:
        needed: Names of the required values for each of the fields `position`, `velocity` and
            `effort`.
        max_delay: Maximum delay, in [s].
        only: Whether messages with other names are rejected.
        parse: Function that converts a message to a joint state.

    Attributes:
        counters: Number of received messages, and number of dropped messages by reason.
        frame: Frame id of the newest valid message.
        publisher: Publisher whose messages are accepted, or None before the first message.
    """

    def __init__(
        self,
        needed: Mapping[str, tuple[str, ...]],
        max_delay: float,
        *,
        only: bool = True,
        parse: Callable[[Received], JointState] = lambda received: JointState.from_message(
            received.message
        ),
    ) -> None:
        self._needed, self._max_delay, self._only = dict(needed), max_delay, only
        self._all = {name for names in needed.values() for name in names}
        self._parse = parse
        self._names: tuple[str, ...] | None = None
        self._indices: dict[str, list[int]] = {}
        self.counters: Counter[str] = Counter()
        self.frame = ""
        self.publisher: Hashable = None
        self._ended: Hashable = None
        self.start()

    def start(self, *, ended: bool = False) -> None:
        """Accept messages of any publisher again.

        Args:
            ended: Whether messages of the current publisher are rejected from now on.
        """
        if ended:
            self._ended = self.publisher
        self.publisher = None
        self._stamp = -1
        self._offset, self._at = math.inf, 0.0

    def read(self, message: Received, now: float) -> dict[str, FloatArray] | None:
        """Return the numbers of a message for each field, or None if the message is invalid.

        The numbers are in the order of `needed`.

        Args:
            now: Time of arrival on a monotonic clock, in [s].
        """
        self.counters["received"] += 1
        values = self._check(message, now)
        if isinstance(values, str):
            self.counters[values] += 1
            return None
        return values

    def _check(self, message: Received, now: float) -> dict[str, FloatArray] | str:
        """Return the numbers of a message, or the reason to drop it."""
        state = self._parse(message)
        if message.publisher is None:
            return "several"
        if message.publisher == self._ended:
            return "ended"
        if self.publisher is not None and message.publisher != self.publisher:
            return "publisher"
        values = self._values(state)
        if isinstance(values, str):
            return values
        if state.time_ns <= self._stamp:
            return "stale"
        self._stamp = state.time_ns
        if self._is_old(now - state.time_ns * 1e-9, now):
            return "old"
        self.publisher, self.frame = message.publisher, state.frame
        return values

    def _values(self, state: JointState) -> dict[str, FloatArray] | str:
        if state.names != self._names and not self._set_names(state.names):
            return "names"
        values = {}
        for field, indices in self._indices.items():
            numbers = getattr(state, field)
            if indices and len(numbers) != len(state.names):
                return "count"
            values[field] = numbers[indices].astype(float)
            if not np.isfinite(values[field]).all():
                return "not finite"
        return values

    def _set_names(self, names: tuple[str, ...]) -> bool:
        """Find the indices of the required names. Return whether the names are valid."""
        index = {name: k for k, name in enumerate(names)}
        is_incomplete = not self._all <= set(index)
        has_others = self._only and len(names) != len(self._all)
        if is_incomplete or len(index) != len(names) or has_others:
            return False
        self._names = names
        self._indices = {
            field: [index[name] for name in names] for field, names in self._needed.items()
        }
        return True

    def _is_old(self, offset: float, now: float) -> bool:
        """Return whether the delay of a message, relative to the fastest message, is too long."""
        self._offset = min(self._offset + _MAX_CLOCK_DRIFT * (now - self._at), offset)
        self._at = now
        return offset - self._offset > self._max_delay
