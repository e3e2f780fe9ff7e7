"""Law of mpc.h for a mass that moves without friction."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from controllers.qp import law_in_c

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


class Law(law_in_c.NamedArrays):
    """Law of mpc.h for a mass of 1 kg, with forces of at most 5 N.

    Attributes:
        reference: Position, velocity and acceleration at the tick; at first rest at q = 1.
        jerk: Rate of the acceleration of the reference.
    """

    def __init__(self, clock: Callable[[], float], deadline: float) -> None:
        self.reference, self.jerk = np.array([1.0, 0.0, 0.0]), 0.0
        c = law_in_c.library()
        c.mpc_size.restype, c.mpc_array.restype = ctypes.c_size_t, ctypes.c_void_p
        c.mpc_open.argtypes = [ctypes.POINTER(_Model), *[ctypes.c_int] * 4, ctypes.c_void_p]
        c.mpc_open.restype = ctypes.c_void_p
        c.mpc_array.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.POINTER(ctypes.c_size_t)]
        c.mpc_solve.argtypes = [ctypes.c_void_p] * 8
        self._c = c
        self._model = _Model(
            None,
            _INTERVALS(_intervals),
            _TASKS(),
            _PREVIEW(self._preview),
            _CLOCK(lambda _: clock()),
        )
        self._memory = np.zeros(c.mpc_size(1, 1, 0, NODES) // 8 + 1)
        handle = c.mpc_open(self._model, 1, 1, 0, NODES, self._memory.ctypes.data)
        super().__init__(c.mpc_array, handle)
        settings = {"horizon": 0.3, "period": PERIOD, "iterations": 50, "tolerance": 1e-10}
        settings |= {"tracking": 1e4, "tracking_rates": 2e2, "accelerations": 1.0}
        settings |= {"forces_cost": 1e-6, "deadline": deadline}
        settings |= {"f_min": -5.0, "f_max": 5.0, "first_min": -5.0, "first_max": 5.0}
        settings |= {"q_min": -np.inf, "q_max": np.inf, "qd_max": np.inf}
        self.write(**settings)

    def tick(self, q: float, qd: float) -> tuple[int, float]:
        """Return the status and the force."""
        numbers = np.array([q, qd, 0.0, 0.0, 0.0, 0.0])
        at, size = numbers.ctypes.data, numbers.itemsize
        zeros = [at + k * size for k in (2, 3)]
        status = self._c.mpc_solve(
            self.handle,
            at,
            at + size,
            self.reference.ctypes.data,
            *zeros,
            at + 4 * size,
            at + 5 * size,
        )
        return status, float(numbers[4])

    def _preview(self, _: Any, ahead: float, now: Any, reference: Any) -> None:
        reference[2] = now[2] + self.jerk * ahead
        reference[1] = now[1] + ahead * (now[2] + self.jerk * ahead / 2)
        reference[0] = now[0] + ahead * (now[1] + ahead * (now[2] / 2 + self.jerk * ahead / 6))
