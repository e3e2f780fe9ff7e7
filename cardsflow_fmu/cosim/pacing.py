"""Real-time pacing: absolute deadlines, lateness, scheduling."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

_REAL_TIME = ("SCHED_FIFO", "SCHED_RR")
_MAX_LATE_FRACTION = 0.01
"""Maximum fraction of steps that are late by more than one step in a run that keeps up."""
_PRIORITY = 20
"""Priority among real-time threads; below those of the operating system."""
_MAX_SLEEP = 0.1
"""Maximum time without a check for Ctrl-C, in [s]."""
_SET_TIMER_SLACK, _GET_TIMER_SLACK = 29, 30
_MIN_SLACK = 1  # [ns]; the default of Linux is 50 µs


class Pacer:
    """Timer that waits for the deadlines of a run in real time.

    All deadlines are relative to one start time, so delays do not add up. If the run is more than
    one step late, it does not catch up in a burst: all later deadlines are postponed.

    Args:
        step: Lateness that is tolerated, in [s].
        clock: Function that returns the time, in [s].
        sleep: Function that waits for a time in [s].

    Attributes:
        slips: Number of postponements.
        slipped: Sum of all postponements, in [s].
    """

    def __init__(
        self,
        step: float,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._step, self._clock, self._sleep = step, clock, sleep
        self._origin: float | None = None
        self.slips = 0
        self.slipped = 0.0

    def wait(self, t: float, is_interrupted: Callable[[], bool] = lambda: False) -> float:
        """Wait until time t of the run. The first call defines the current time as t.

        Args:
            t: Time of the run, in [s].
            is_interrupted: Called regularly; if it returns true, the wait ends.

        Returns:
            The lateness, in [s]; 0 or more.
        """
        if self._origin is None:
            self._origin = self._clock() - t
            return 0.0
        due = self._origin + t
        rest = due - self._clock()
        while rest > 0.0 and not is_interrupted():
            self._sleep(min(rest, _MAX_SLEEP))
            rest = due - self._clock()
        if -rest > self._step:
            self._origin -= rest
            self.slips += 1
            self.slipped -= rest
        return max(-rest, 0.0)


def timeliness(lateness: FloatArray, step: float) -> dict[str, Any]:
    """Evaluate the lateness of a run's steps.

    Args:
        lateness: Lateness of each step, shape (steps,), in [s].
        step: Communication step, in [s]. A run that keeps up is rarely later than this.
    """
    if not lateness.size:
        return {"kept_up": None, "steps": 0, "behind": 0, "unit": "s", "lateness": None}
    median, p99, maximum = np.quantile(lateness, [0.5, 0.99, 1.0])
    behind = int(np.count_nonzero(lateness > step))
    return {
        "kept_up": behind <= _MAX_LATE_FRACTION * lateness.size,
        "steps": int(lateness.size),
        "behind": behind,
        "late_by_half_a_millisecond": float(np.mean(lateness > 5e-4)),
        "lateness": {"median": float(median), "p99": float(p99), "max": float(maximum)},
        "unit": "s",
    }


def describe_timeliness(report: Mapping[str, Any]) -> str:
    """Describe the lateness in one line."""
    if report["kept_up"] is None:
        return "no step was paced"
    median, p99, maximum = (1e3 * report["lateness"][key] for key in ("median", "p99", "max"))
    verdict = "kept up" if report["kept_up"] else "did NOT keep up"
    return (
        f"{verdict}: {report['behind']} of {report['steps']} steps late by more than a step; "
        f"lateness median {median:.3g}, 99 % {p99:.3g}, max {maximum:.3g} ms"
    )


@contextmanager
def without_collections() -> Iterator[None]:
    """Disable garbage collection, which can take longer than a step."""
    was_enabled = gc.isenabled()
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        yield
    finally:
        gc.unfreeze()
        if was_enabled:
            gc.enable()


@contextmanager
def real_time_priority() -> Iterator[str]:
    """Run this thread with real-time scheduling and precise timers, if the system permits it.

    Yields:
        The name of the scheduling policy.
    """
    slack = _timer_slack(_MIN_SLACK)
    before = _request_priority()
    try:
        yield scheduling()
    finally:
        if before is not None:
            with suppress(OSError):
                os.sched_setscheduler(0, *before)
        if slack not in (None, _MIN_SLACK):
            _timer_slack(slack)


def scheduling() -> str:
    """Return the name of this thread's scheduling policy."""
    if not hasattr(os, "sched_getscheduler"):
        return "system default"
    names = {getattr(os, name, None): name for name in ("SCHED_FIFO", "SCHED_RR", "SCHED_OTHER")}
    policy = os.sched_getscheduler(0) & ~getattr(os, "SCHED_RESET_ON_FORK", 0)
    return names.get(policy, f"policy {policy}")


def _request_priority() -> tuple[int, Any] | None:
    """Request SCHED_FIFO; return the previous policy, or None if nothing changed."""
    if sys.platform != "linux":
        return None
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    if scheduling() in _REAL_TIME:  # the caller restores it
        return None
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(_PRIORITY))
    except OSError:
        return None
    return before


def _timer_slack(nanoseconds: int) -> int | None:
    """Set the timer slack of this thread; return the previous value, or None if unknown."""
    if sys.platform != "linux":
        return None
    try:
        control = ctypes.CDLL(None).prctl
    except (OSError, AttributeError):
        return None
    before = int(control(_GET_TIMER_SLACK, 0, 0, 0, 0))
    control(_SET_TIMER_SLACK, ctypes.c_ulong(nanoseconds), 0, 0, 0)
    return before if before > 0 else None
