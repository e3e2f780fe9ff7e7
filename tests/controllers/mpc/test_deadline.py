"""Deadline of model predictive control, with a clock that the test advances."""

from __future__ import annotations

import pytest
from support.controllers.predicted_mass import Law

from controllers.qp import law_in_c

SOLVED, NEXT = law_in_c.SOLVED, law_in_c.NEXT


class Clock:
    """Clock that advances by the same time at each reading."""

    def __init__(self, step: float) -> None:
        self.time, self.step, self.readings = 100.0, step, 0

    def __call__(self) -> float:
        self.time, self.readings = self.time + self.step, self.readings + 1
        return self.time


def test_iterations_end_before_the_deadline() -> None:
    """At 1 ms each, four of them end within 5.5 ms, after 1 ms for the linearized motion."""
    clock = Clock(0.0)
    law = Law(clock, 5.5e-3)
    assert law.tick(0.0, 0.0)[0] == SOLVED
    clock.step = 1e-3
    assert law.tick(0.0, 0.05)[0] == NEXT
    assert law["is_late"][0] == 1.0
    assert law["used"][0] == 4.0


def test_tick_after_a_late_one_starts_from_the_last_motion() -> None:
    clock = Clock(0.0)
    law, other = Law(clock, 2e-3), Law(Clock(0.0), 0.0)
    states = [(0.0, 0.0), (2.5e-4, 0.05), (1e-3, 0.1)]
    for k, state in enumerate(states):
        clock.step = 1e-2 if k == 1 else 0.0
        status, force = law.tick(*state)
        expected = other.tick(*state)
        assert status == (NEXT if k == 1 else SOLVED)
    assert force == pytest.approx(expected[1], abs=1e-3)
    assert law["used"][0] <= 12.0  # one step, not several as from rest


def test_pause_after_the_last_iteration_is_late_too() -> None:
    clock = Clock(0.0)
    assert Law(clock, 5e-3).tick(0.0, 0.0)[0] == SOLVED
    last, paused = clock.readings, Clock(0.0)

    def read() -> float:
        paused.step = 1.0 if paused.readings == last - 1 else 0.0
        return paused()

    law = Law(read, 5e-3)
    assert law.tick(0.0, 0.0)[0] == SOLVED
    assert law["is_late"][0] == 1.0


def test_clock_is_unused_without_deadline() -> None:
    clock = Clock(1e3)
    law, other = Law(clock, 0.0), Law(Clock(0.0), 1e-3)
    for state in [(0.0, 0.0), (2.5e-4, 0.05), (1e-3, 0.1)]:
        assert law.tick(*state) == other.tick(*state)
    assert clock.readings == 0
