"""Pacing by the clock: absolute deadlines, lateness, real-time scheduling."""

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
_SELDOM = 0.01
"""Part of the steps that may be late by more than a step in a run that keeps up."""
_PRIORITY = 20
"""Among real-time threads; above nothing that a system's own are."""
_SET_TIMER_SLACK, _GET_TIMER_SLACK = 29, 30
_LEAST_SLACK = 1  # [ns]; a system's own choice is 50 µs


class Pacer:
    """Waits for moments of real time that stand as far apart as those of a run.

    Every moment is counted from one origin, so that delays do not add up. Who is more than a step
    late is not made to catch up in a burst: all later moments slip by as much.

    Args:
        step: The step that a run may be late by, in [s].
        clock: The time, in [s].
        sleep: Waits for a time in [s].

    Attributes:
        slips: How often moments slipped.
        slipped: By how much altogether, in [s].
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

    def wait(self, t: float) -> float:
        """Wait until time t of the run; the first call says that it is now.

        Args:
            t: In [s].

        Returns:
            How late it is, in [s]; 0 or more.
        """
        if self._origin is None:
            self._origin = self._clock() - t
            return 0.0
        due = self._origin + t
        rest = due - self._clock()
        while rest > 0.0:
            self._sleep(rest)
            rest = due - self._clock()
        if -rest > self._step:
            self._origin -= rest
            self.slips += 1
            self.slipped -= rest
        return -rest


def timeliness(lateness: FloatArray, step: float) -> dict[str, Any]:
    """Lateness of the steps of a run, and whether it kept up.

    Args:
        lateness: Of every step, shape (steps,), in [s].
        step: In [s]; a run that keeps up is seldom later than this.
    """
    if not lateness.size:
        return {"kept_up": None, "steps": 0, "behind": 0, "unit": "s", "lateness": None}
    median, most, highest = np.quantile(lateness, [0.5, 0.99, 1.0])
    behind = int(np.count_nonzero(lateness > step))
    return {
        "kept_up": behind <= _SELDOM * lateness.size,
        "steps": int(lateness.size),
        "behind": behind,
        "late_by_half_a_millisecond": float(np.mean(lateness > 5e-4)),
        "lateness": {"median": float(median), "p99": float(most), "max": float(highest)},
        "unit": "s",
    }


def describe_timeliness(report: Mapping[str, Any]) -> str:
    """One line of text about the timeliness."""
    if report["kept_up"] is None:
        return "no step was paced"
    median, most, highest = (1e3 * report["lateness"][key] for key in ("median", "p99", "max"))
    verdict = "kept up" if report["kept_up"] else "did NOT keep up"
    return (
        f"{verdict}: {report['behind']} of {report['steps']} steps late by more than a step; "
        f"lateness median {median:.3g}, 99 % {most:.3g}, max {highest:.3g} ms"
    )


@contextmanager
def without_collections() -> Iterator[None]:
    """No collection of garbage meanwhile: one takes longer than steps may."""
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
    """This thread goes before others, and is woken on time, as far as the system permits.

    Yields:
        The name of the scheduling that it has.
    """
    slack = _timer_slack(_LEAST_SLACK)
    before = _take_priority()
    try:
        yield scheduling()
    finally:
        if before is not None:
            with suppress(OSError):
                os.sched_setscheduler(0, *before)
        if slack not in (None, _LEAST_SLACK):
            _timer_slack(slack)


def scheduling() -> str:
    """The name of this thread's scheduling."""
    if not hasattr(os, "sched_getscheduler"):
        return "the system's own"
    names = {getattr(os, name, None): name for name in ("SCHED_FIFO", "SCHED_RR", "SCHED_OTHER")}
    own = os.sched_getscheduler(0) & ~getattr(os, "SCHED_RESET_ON_FORK", 0)
    return names.get(own, f"policy {own}")


def _take_priority() -> tuple[int, Any] | None:
    """Ask for SCHED_FIFO; what there was before, or None where nothing is to be given back."""
    if sys.platform != "linux":
        return None
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    if scheduling() in _REAL_TIME:  # taken and given back by a caller
        return None
    policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
    try:
        os.sched_setscheduler(0, policy, os.sched_param(_PRIORITY))
    except OSError:
        return None
    return before


def _timer_slack(nanoseconds: int) -> int | None:
    """Let timers of this thread be late by so much; what it was, None where it is unknown."""
    if sys.platform != "linux":
        return None
    try:
        control = ctypes.CDLL(None).prctl
    except (OSError, AttributeError):
        return None
    before = int(control(_GET_TIMER_SLACK, 0, 0, 0, 0))
    control(_SET_TIMER_SLACK, ctypes.c_ulong(nanoseconds), 0, 0, 0)
    return before if before > 0 else None
