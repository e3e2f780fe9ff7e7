"""Binding of the dual Newton QP solver in C."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError
from controllers.arrays import FloatArray

SOLVED, INFEASIBLE, NOT_CONVERGED, WRONG_COST, WRONG_BOUNDS, WRONG_ROWS = range(6)

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


@cache
def library() -> ctypes.PyDLL:
    """Return the loaded solver.

    Loaded with the Python lock held during calls: they take microseconds.

    Raises:
        CardsflowError: The library is missing.
    """
    root = Path(os.environ.get("CARDSFLOW_LIBRARY_DIR", Path(__file__).parents[2]))
    path = root / "controllers" / "lib" / f"cardsflow_control{_SUFFIX}"
    if not path.is_file():
        raise CardsflowError(f"{path}: the QP solver is missing; reinstall cardsflow to compile it")
    solver = ctypes.PyDLL(str(path))
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    solver.dual_newton_size.argtypes = [ctypes.c_int, ctypes.c_int]
    solver.dual_newton_size.restype = size
    solver.dual_newton_open.argtypes = [ctypes.c_int, ctypes.c_int, pointer]
    solver.dual_newton_open.restype = pointer
    solver.dual_newton_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
    solver.dual_newton_array.restype = ctypes.POINTER(ctypes.c_double)
    solver.dual_newton_solve.argtypes = [pointer]
    solver.dual_newton_steps.argtypes = [pointer]
    solver.least_largest.argtypes = [pointer, _Box, pointer, pointer, pointer]
    return solver


class _Box(ctypes.Structure):
    """Addresses of bounds: `box` of csrc/qp/linear.h."""

    _fields_ = (("low", ctypes.c_void_p), ("high", ctypes.c_void_p))


class DualNewton:
    """A solver for problems of one size; see csrc/qp/dual_newton.h.

    The arrays are the solver's own memory: write the problem into them, call `solve`, and read the
    answer. Inputs are neither copied nor checked, apart from the status that `solve` returns.

    Args:
        n: Number of variables.
        m_eq: Number of rows.

    Raises:
        InputError: A size is not positive or too large.

    Attributes:
        H_diagonal, g, lb, ub: Of the problem, shape (n,).
        A: Of the problem, shape (m_eq, n); its transpose is contiguous.
        b, softness: Of the problem, shape (m_eq,).
        start: Multipliers to start from, shape (m_eq,); `solve` leaves those of a solved problem.
        x: Of the answer, shape (n,).
        multipliers, slack: Of the answer, shape (m_eq,).
        residuals: Of the answer, relative: of the rows, and of the dual.
    """

    def __init__(self, n: int, m_eq: int) -> None:
        solver = library()
        size = solver.dual_newton_size(n, m_eq)
        if not size:
            raise InputError(
                f"a problem of {n} variables and {m_eq} rows is too small or too large"
            )
        self._memory = np.empty((size + 7) // 8)
        self._open(solver.dual_newton_open(n, m_eq, self._memory.ctypes.data))

    @classmethod
    def at(cls, handle: int) -> DualNewton:
        """Return the solver of a handle whose memory belongs to another."""
        self = cls.__new__(cls)
        self._open(handle)
        return self

    def _open(self, handle: int) -> None:
        solver = library()
        self._handle = ctypes.c_void_p(handle)
        self._solve, self._steps = solver.dual_newton_solve, solver.dual_newton_steps
        self.H_diagonal, self.g, self.lb, self.ub, self.x, A = map(
            self._array, ("H_diagonal", "g", "lb", "ub", "x", "A")
        )
        self.b, self.softness, self.start, self.multipliers, self.slack, self.residuals = map(
            self._array, ("b", "softness", "start", "multipliers", "slack", "residuals")
        )
        self.A = A.reshape(self.g.size, self.b.size).T

    def _array(self, name: str) -> FloatArray:
        length = ctypes.c_size_t()
        pointer = library().dual_newton_array(self._handle, name.encode(), ctypes.byref(length))
        assert pointer, name
        return np.ctypeslib.as_array(pointer, (length.value,))

    def solve(self) -> int:
        """Solve the problem in the arrays; one of the constants above."""
        status: int = self._solve(self._handle)
        return status

    def least_largest(
        self, low: FloatArray, high: FloatArray, c: FloatArray, p: FloatArray, first: FloatArray
    ) -> int:
        """Solve min max c_i |x_i - p_i| over the rows in the arrays, low <= x <= high.

        Of several answers x is the one nearest to p.

        Args:
            low: Shape (n,).
            high: Shape (n,).
            c: Shape (n,), not negative.
            p: Shape (n,).
            first: An x that fulfils rows and bounds, shape (n,).

        Returns:
            One of the constants above.
        """
        vectors = [np.ascontiguousarray(v, dtype=np.float64) for v in (low, high, c, p, first)]
        low_, high_, *others = (vector.ctypes.data for vector in vectors)
        status: int = library().least_largest(self._handle, _Box(low_, high_), *others)
        return status

    @property
    def steps(self) -> int:
        """Newton steps of the last call."""
        count: int = self._steps(self._handle)
        return count
