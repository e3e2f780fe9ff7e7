"""Absolute deadlines, tested with a simulated clock."""

from __future__ import annotations

import gc
import os
import sys
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cardsflow_fmu.cosim.pacing import (
    Pacer,
    describe_timeliness,
    real_time_priority,
    scheduling,
    timeliness,
    without_collections,
)


class Clock:
    """Clock that advances by the time slept and by the time the test adds."""

    def __init__(self, oversleep: float = 0.0) -> None:
        self.now, self._oversleep = 100.0, oversleep

    def read(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0
        self.now += seconds + self._oversleep


def paced(clock: Clock, step: float = 0.01) -> Pacer:
    return Pacer(step, clock=clock.read, sleep=clock.sleep)


def test_deadlines_are_relative_to_the_first_call() -> None:
    clock = Clock()
    pacer = paced(clock)
    assert pacer.wait(2.0) == 0.0
    assert clock.now == 100.0
    pacer.wait(2.01)
    pacer.wait(2.03)
    assert clock.now == pytest.approx(100.03, abs=1e-12)


def test_lateness_does_not_add_up() -> None:
    """Every sleep is 2 ms too long; relative sleeps would be 2 s late after 1000 steps."""
    clock = Clock(oversleep=0.002)
    pacer = paced(clock)
    lateness = [pacer.wait(0.01 * k) for k in range(1001)]
    assert max(lateness) == pytest.approx(0.002, abs=1e-9)
    assert clock.now == pytest.approx(110.002, abs=1e-9)
    assert pacer.slips == 0


def test_delays_below_one_step_are_compensated() -> None:
    clock = Clock()
    pacer = paced(clock)
    pacer.wait(0.0)
    clock.now += 0.018
    assert pacer.wait(0.01) == pytest.approx(0.008)
    pacer.wait(0.02)
    assert clock.now == pytest.approx(100.02)


def test_delays_above_one_step_postpone_later_deadlines() -> None:
    clock = Clock()
    pacer = paced(clock)
    pacer.wait(0.0)
    clock.now += 0.2
    assert pacer.wait(0.01) == pytest.approx(0.19)
    begin = clock.now
    for k in range(2, 12):
        assert pacer.wait(0.01 * k) == pytest.approx(0.0, abs=1e-9)
    assert clock.now - begin == pytest.approx(0.1)
    assert (pacer.slips, pacer.slipped) == (1, pytest.approx(0.19))


@given(st.lists(st.floats(0.0, 0.05), min_size=1, max_size=50))
def test_deadlines_differ_by_at_least_one_step_minus_the_lateness(delays: list[float]) -> None:
    """After any delay, no step starts too early."""
    clock = Clock()
    pacer = paced(clock)
    pacer.wait(0.0)
    at, late = clock.now, 0.0
    for k, delay in enumerate(delays, 1):
        clock.now += delay
        slips = pacer.slips
        now_late = pacer.wait(0.01 * k)
        kept = 0.0 if pacer.slips > slips else now_late
        assert clock.now - at >= 0.01 - late - 1e-9
        at, late = clock.now, kept


def test_real_sleeps_are_never_too_short() -> None:
    pacer = Pacer(0.002)
    pacer.wait(0.0)
    begin = time.monotonic()
    for k in range(1, 26):
        assert pacer.wait(0.002 * k) >= 0.0
    assert time.monotonic() - begin >= 0.05 - 1e-4


def test_the_report_contains_the_lateness() -> None:
    lateness = np.array([0.0] * 98 + [0.0015, 0.004])
    report = timeliness(lateness, 0.002)
    assert report["kept_up"]
    assert (report["steps"], report["behind"]) == (100, 1)
    assert report["late_by_half_a_millisecond"] == 0.02
    assert report["lateness"]["max"] == 0.004
    assert "1 of 100 steps late by more than a step" in describe_timeliness(report)
    slow = timeliness(np.full(50, 0.01), 0.002)
    assert not slow["kept_up"]
    assert describe_timeliness(slow).startswith("did NOT keep up: 50 of 50")
    assert describe_timeliness(timeliness(np.empty(0), 0.002)) == "no step was paced"


@pytest.mark.skipif(sys.platform != "linux", reason="scheduling of Linux")
def test_scheduling_is_restored() -> None:
    before = os.sched_getscheduler(0)
    with real_time_priority() as name:
        assert name == scheduling()
        assert name in ("SCHED_FIFO", "SCHED_OTHER", "SCHED_RR")
        with real_time_priority() as inner:
            assert inner == name
        assert scheduling() == name
    assert os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK == before


@pytest.mark.skipif(sys.platform != "linux", reason="scheduling of Linux")
def test_priority_is_restored_by_the_outermost_context() -> None:
    before = scheduling()
    first, second = real_time_priority(), real_time_priority()
    first.__enter__()
    second.__enter__()
    first.__exit__(None, None, None)
    second.__exit__(None, None, None)
    assert scheduling() == before


@pytest.mark.skipif(sys.platform != "linux", reason="scheduling of Linux")
def test_without_permission_priority_is_unchanged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    with real_time_priority() as name:
        assert name == scheduling()


@pytest.mark.slow
def test_garbage_collection_is_disabled() -> None:
    assert gc.isenabled()
    with without_collections():
        assert not gc.isenabled()
    assert gc.isenabled()
    assert gc.get_freeze_count() == 0
