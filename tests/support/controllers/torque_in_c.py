"""The computed-torque laws in C, by their own interface."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.qp.dual_newton import library

SOLVED, SOFT, NOT_CONVERGED, FAILED, WRONG = range(5)


class TorqueInC:
    """A law for n coordinates, m muscles and k task coordinates; in joint space if k is 0."""

    def __init__(self, n: int, m: int, k: int = 0) -> None:
        self._library = lib = library()
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        lib.computed_torque_size.restype = size
        lib.computed_torque_open.argtypes = [*[ctypes.c_int] * 3, pointer]
        lib.computed_torque_open.restype = pointer
        lib.computed_torque_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
        lib.computed_torque_array.restype = ctypes.POINTER(ctypes.c_double)
        self._memory = np.empty((lib.computed_torque_size(n, m, k) + 7) // 8)
        address = lib.computed_torque_open(n, m, k, self._memory.ctypes.data)
        self._handle = pointer(address)

    def array(self, name: str) -> FloatArray:
        """A view of an array, flat."""
        length = ctypes.c_size_t()
        found = self._library.computed_torque_array(
            self._handle, name.encode(), ctypes.byref(length)
        )
        assert found, name
        view: FloatArray = np.ctypeslib.as_array(found, (length.value,))
        return view

    def write(self, **arrays: ArrayLike) -> None:
        """Write arrays by name."""
        for name, values in arrays.items():
            self.array(name)[:] = np.ravel(np.asarray(values, dtype=float))

    def reset(self) -> None:
        """Forget the calls before."""
        self._library.computed_torque_reset(self._handle)

    def solve(self, **arrays: Any) -> int:
        """The status for some arrays."""
        self.write(**arrays)
        return int(self._library.computed_torque_solve(self._handle))
