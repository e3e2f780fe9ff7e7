"""Checks of what comes on a topic, which has neither handshake nor signature.

A message counts if it has all names and no others, a finite number for each, a newer stamp than the
one before, is not older than allowed, and is from the publisher of the first, which is the topic's
only one.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping

import numpy as np

from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.node import Received
from cardsflow_fmu.utils.arrays import FloatArray

_DRIFT = 1e-3
"""How much faster one clock may run than the other: more is taken for a growing delay."""

REASONS = {
    "names": "messages have other names",
    "count": "messages have numbers for some names only",
    "not finite": "messages have numbers that are not finite",
    "several": "several nodes publish: none of their messages counts",
    "publisher": "another node publishes now: its messages are dropped",
    "stale": "messages have no newer stamps than those before",
    "old": "messages come late",
    "ended": "messages come from a node whose commands were ended: it has to begin anew",
}


class TopicReader:
    """Reads the messages of a topic.

    The clocks of both sides need not agree: the delay of a message is counted from the fastest one.

    Args:
        needed: Names whose numbers a message must have, by the fields `position`, `velocity`,
            `effort`.
        longest: Largest delay, in [s].
        only: Whether other names than these are rejected.
        parse: The joint states in a message.

    Attributes:
        counters: Messages received, and messages dropped by reason.
        frame: The frame of the newest message that counts.
        publisher: Whose messages count; None before any.
    """

    def __init__(
        self,
        needed: Mapping[str, tuple[str, ...]],
        longest: float,
        *,
        only: bool = True,
        parse: Callable[[Received], JointState] = lambda received: JointState.of(received.message),
    ) -> None:
        self._needed, self._longest, self._only = dict(needed), longest, only
        self._all = {name for names in needed.values() for name in names}
        self._parse = parse
        self._names: tuple[str, ...] | None = None
        self._places: dict[str, list[int]] = {}
        self.counters: Counter[str] = Counter()
        self.frame = ""
        self.publisher: Hashable = None
        self._ended: Hashable = None
        self.start()

    def start(self, *, ended: bool = False) -> None:
        """Take messages of any publisher again.

        Args:
            ended: Whether those of the present one are rejected from now on.
        """
        if ended:
            self._ended = self.publisher
        self.publisher = None
        self._stamp = -1
        self._offset, self._at = math.inf, 0.0

    def read(self, message: Received, now: float) -> dict[str, FloatArray] | None:
        """The numbers of a message by fields, in the order of `needed`; None if it does not count.

        Args:
            message: The message.
            now: When it came, on a clock that does not jump, in [s].
        """
        self.counters["received"] += 1
        found = self._checked(message, now)
        if isinstance(found, str):
            self.counters[found] += 1
            return None
        return found

    def _checked(self, message: Received, now: float) -> dict[str, FloatArray] | str:
        """Return the numbers of a message, or the reason to drop it."""
        found = self._parse(message)
        if message.publisher is None:
            return "several"
        if message.publisher == self._ended:
            return "ended"
        if self.publisher is not None and message.publisher != self.publisher:
            return "publisher"
        values = self._values(found)
        if isinstance(values, str):
            return values
        if found.time_ns <= self._stamp:
            return "stale"
        self._stamp = found.time_ns
        if self._is_old(now - found.time_ns * 1e-9, now):
            return "old"
        self.publisher, self.frame = message.publisher, found.frame
        return values

    def _values(self, found: JointState) -> dict[str, FloatArray] | str:
        if found.names != self._names and not self._take_names(found.names):
            return "names"
        values = {}
        for field, places in self._places.items():
            numbers = getattr(found, field)
            if places and len(numbers) != len(found.names):
                return "count"
            values[field] = numbers[places].astype(float)
            if not np.isfinite(values[field]).all():
                return "not finite"
        return values

    def _take_names(self, names: tuple[str, ...]) -> bool:
        """Find the places of the names that are needed; False if they are others."""
        place = {name: k for k, name in enumerate(names)}
        missing = not self._all <= set(place)
        if missing or len(place) != len(names) or (self._only and len(names) != len(self._all)):
            return False
        self._names = names
        self._places = {
            field: [place[name] for name in names] for field, names in self._needed.items()
        }
        return True

    def _is_old(self, offset: float, now: float) -> bool:
        """Return whether a message has taken longer than the fastest one by more than is allowed.

        Args:
            offset: From its stamp to its coming: the clocks' offset and the delay, in [s].
            now: In [s].
        """
        self._offset = min(self._offset + _DRIFT * (now - self._at), offset)
        self._at = now
        return offset - self._offset > self._longest
