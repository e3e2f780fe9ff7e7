"""Deadline of model predictive control, with a clock that the test advances."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from controllers.qp import law_in_c

SOLVED, NEXT = law_in_c.SOLVED, law_in_c.NEXT
NODES, PERIOD = 6, 0.01

_pointer = ctypes.POINTER(ctypes.c_double)
_INTERVALS = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, *[_pointer] * 6)
_TASKS = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *[_pointer] * 6)
_PREVIEW = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double, _pointer, _pointer)
_CLOCK = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p)


class _Model(ctypes.Structure):
    _fields_ = [
        ("self", ctypes.c_void_p),
        ("intervals", _INTERVALS),
        ("tasks", _TASKS),
        ("preview", _PREVIEW),
        ("clock", _CLOCK),
    ]


def _intervals(_: Any, h: Any, x: Any, forces: Any, load: Any, ends: Any, derivatives: Any) -> int:
    """Simulate a mass of 1 kg: x = (q, qd), qd' = f - load."""
    for k in range(NODES):
        T, q, qd, a = h[k], x[2 * k], x[2 * k + 1], forces[k] - load[0]
        ends[2 * k], ends[2 * k + 1] = q + T * qd + T * T * a / 2, qd + T * a
        for i, value in enumerate([T * T / 2, 1.0, T, T, 0.0, 1.0]):
            derivatives[6 * k + i] = value
    return 0


class Law:
    """Law of mpc.h for a mass that moves to q = 1, with forces of at most 5 N."""

    def __init__(self, clock: Callable[[], float], deadline: float) -> None:
        c = law_in_c.library()
        c.mpc_size.restype, c.mpc_array.restype = ctypes.c_size_t, ctypes.c_void_p
        c.mpc_open.argtypes = [ctypes.POINTER(_Model), *[ctypes.c_int] * 4, ctypes.c_void_p]
        c.mpc_open.restype = ctypes.c_void_p
        c.mpc_array.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_size_t)]
        c.mpc_solve.argtypes = [ctypes.c_void_p] * 8
        self._c = c
        self._model = _Model(
            None, _INTERVALS(_intervals), _TASKS(), _PREVIEW(_preview), _CLOCK(lambda _: clock())
        )
        self._memory = np.zeros(c.mpc_size(1, 1, 0, NODES) // 8 + 1)
        self._law = c.mpc_open(self._model, 1, 1, 0, NODES, self._memory.ctypes.data)
        settings = {"horizon": 0.3, "period": PERIOD, "iterations": 50, "tolerance": 1e-10}
        settings |= {"tracking": 1e4, "tracking_rates": 2e2, "accelerations": 1.0}
        settings |= {"forces_cost": 1e-6, "deadline": deadline}
        settings |= {"f_min": -5.0, "f_max": 5.0, "first_min": -5.0, "first_max": 5.0}
        settings |= {"q_min": -np.inf, "q_max": np.inf, "qd_max": np.inf}
        for name, value in settings.items():
            self[name][:] = value

    def __getitem__(self, name: str) -> Any:
        length = ctypes.c_size_t()
        address = self._c.mpc_array(self._law, name.encode(), ctypes.byref(length))
        return law_in_c.view(address, length.value)

    def tick(self, q: float, qd: float) -> tuple[int, float]:
        """Return the status and the force."""
        numbers = np.array([q, qd, 0.0, 0.0, 0.0, 0.0])
        reference = np.array([1.0, 0.0, 0.0])
        at, size = numbers.ctypes.data, numbers.itemsize
        zeros = [at + k * size for k in (2, 3)]
        status = self._c.mpc_solve(
            self._law, at, at + size, reference.ctypes.data, *zeros, at + 4 * size, at + 5 * size
        )
        return status, float(numbers[4])


def _preview(_: Any, ahead: float, now: Any, reference: Any) -> None:
    for i in range(3):
        reference[i] = now[i]


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
