"""Rules for messages on a topic: names, numbers, order, age, one publisher."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from support.ros.bus import as_message

from cardsflow_fmu.hardware.protocol.topic_reader import TopicReader
from cardsflow_fmu.ros_interface.joint_state import JointState
from cardsflow_fmu.ros_interface.node import Received

NAMES = ("biceps", "triceps", "elbow")
OFFSET = 1.7e9
"""Offset of the publisher's clock relative to the reader's clock, in [s]."""


def message(
    t: float,
    values: Sequence[float] = (1, 2, 3),
    names: Sequence[str] = NAMES,
    by: int | None = 1,
) -> Received:
    time_ns = round((t + OFFSET) * 1e9)
    state = JointState(time_ns, "", tuple(names), effort=np.array(values, float))
    return Received(as_message(state.values), by, time_ns)


def reader(longest: float = 0.1) -> TopicReader:
    return TopicReader({"effort": NAMES}, longest)


def test_numbers_are_found_by_their_names() -> None:
    taken = reader()
    for k, order in enumerate(([0, 1, 2], [2, 0, 1])):
        there = [NAMES[i] for i in order]
        values = taken.read(message(k, [10.0 * i for i in order], there), k)
        assert values is not None
        assert values["effort"].tolist() == [0.0, 10.0, 20.0]


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (message(1, [1, 2], NAMES[:2]), "names"),
        (message(1, [1, 2, 3, 4], [*NAMES, "wrist"]), "names"),
        (message(1, [1, 2, 3], ["biceps", "biceps", "elbow"]), "names"),
        (message(1, []), "count"),
        (message(1, [1, float("nan"), 3]), "not finite"),
        (message(1, [1, 2, float("inf")]), "not finite"),
        (message(0), "stale"),
        (message(1, by=2), "publisher"),
        (message(1, by=None), "several"),
    ],
)
def test_invalid_messages_are_dropped(given: Received, reason: str) -> None:
    taken = reader()
    assert taken.read(message(0), 0.001) is not None
    assert taken.read(given, 1.001) is None
    assert dict(taken.counters) == {"received": 2, reason: 1}
    assert taken.read(message(2), 2.001) is not None


def test_delays_are_relative_to_the_fastest_message() -> None:
    taken = reader(0.1)
    delays = [0.05, 0.02, 0.11, 0.13, 0.02]
    counts = [taken.read(message(k, by=1), k + delay) is not None for k, delay in enumerate(delays)]
    # 0.13 exceeds 0.02 by more than 0.1 plus the maximum clock drift
    assert counts == [True, True, True, False, True]


def test_clocks_may_drift_for_hours() -> None:
    taken = reader(0.05)
    drift = 1 + 2e-4
    assert all(taken.read(message(t * drift), float(t)) is not None for t in range(0, 7200, 10))


def test_an_ended_publisher_is_rejected_until_it_restarts() -> None:
    taken = reader()
    assert taken.read(message(0), 0.0) is not None
    taken.start(ended=True)
    assert taken.read(message(1), 1.0) is None
    assert taken.counters["ended"] == 1
    assert taken.read(message(-5, by=2), 2.0) is not None  # with another clock
    assert taken.publisher == 2
