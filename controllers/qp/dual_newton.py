"""Binding of the dual Newton QP solver in C."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError
from controllers.arrays import FloatArray

SOLVED, INFEASIBLE, NOT_CONVERGED, WRONG_COST, WRONG_BOUNDS, WRONG_ROWS = range(6)

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


@cache
def library() -> ctypes.PyDLL:
    """Load the library of the solver and return it.

    Calls do not release the Python lock (GIL), since they only take microseconds.

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
    solver.dual_newton_array.restype = pointer
    solver.dual_newton_solve.argtypes = [pointer]
    solver.minimize_largest.argtypes = [pointer, _Box, pointer, pointer, pointer]
    return solver


def array_of(find: Any, handle: ctypes.c_void_p, name: str) -> FloatArray:
    """Return a `view` of an array by its name; `find` is the function of the C library."""
    length = ctypes.c_size_t()
    address = find(handle, name.encode(), ctypes.byref(length))
    assert address, name
    return view(address, length.value)


def view(address: int, length: int) -> FloatArray:
    """Return a view of C memory as an array; the memory must outlive the array."""
    memory = (ctypes.c_double * length).from_address(address)
    return np.frombuffer(memoryview(memory).cast("B")) if length else np.empty(0)


class _Box(ctypes.Structure):
    """The C structure `box` in csrc/qp/linear.h: addresses of lower and upper bounds."""

    _fields_ = (("low", ctypes.c_void_p), ("high", ctypes.c_void_p))


class DualNewton:
    """Solver for problems of a fixed size; see csrc/qp/dual_newton.h.

    The arrays are views of the solver memory. Write the problem to the arrays, call `solve`, and
    read the solution from the arrays. The solver does not copy inputs. The status of `solve`
    reports invalid inputs.

    Args:
        n: Number of variables.
        m_eq: Number of equality rows.

    Raises:
        InputError: A size is not positive or too large.

    Attributes:
        H_diagonal, g, lb, ub: Cost and bounds of the problem, shape (n,).
        A: Equality matrix of the problem, shape (m_eq, n); its transpose is contiguous.
        b, softness: Right-hand side and softness of the rows, shape (m_eq,).
        start: Start value of the multipliers, shape (m_eq,). After a successful `solve`, it
            contains the multipliers of the solution.
        x: Solution, shape (n,).
        multipliers, slack: Multipliers and slack of the solution, shape (m_eq,).
        residuals: Relative primal and dual residuals of the solution, shape (2,).
    """

    def __init__(self, n: int, m_eq: int) -> None:
        solver = library()
        size = solver.dual_newton_size(n, m_eq)
        if not size:
            raise InputError(f"a QP with {n} variables and {m_eq} rows is too small or too large")
        self._memory = np.empty((size + 7) // 8)
        self._open(solver.dual_newton_open(n, m_eq, self._memory.ctypes.data))

    @classmethod
    def at(cls, handle: int) -> DualNewton:
        """Return the solver of a handle; its memory must outlive the returned object."""
        self = cls.__new__(cls)
        self._open(handle)
        return self

    def _open(self, handle: int) -> None:
        solver = library()
        self._handle = ctypes.c_void_p(handle)
        self._solve = solver.dual_newton_solve
        self.H_diagonal, self.g, self.lb, self.ub, self.x, A = map(
            self._array, ("H_diagonal", "g", "lb", "ub", "x", "A")
        )
        self.b, self.softness, self.start, self.multipliers, self.slack, self.residuals = map(
            self._array, ("b", "softness", "start", "multipliers", "slack", "residuals")
        )
        self.A = A.reshape(self.g.size, self.b.size).T

    def _array(self, name: str) -> FloatArray:
        return array_of(library().dual_newton_array, self._handle, name)

    def solve(self) -> int:
        """Solve the problem in the arrays and return a status constant of this module."""
        status: int = self._solve(self._handle)
        return status

    def minimize_largest(
        self, low: FloatArray, high: FloatArray, c: FloatArray, p: FloatArray, first: FloatArray
    ) -> int:
        """Solve min max c_i |x_i - p_i| subject to the rows in the arrays and low <= x <= high.

        If several solutions exist, the solver returns the one nearest to p.

        Args:
            low: Lower bounds, shape (n,).
            high: Upper bounds, shape (n,).
            c: Non-negative weights, shape (n,).
            p: Target, shape (n,).
            first: A feasible x, shape (n,).

        Returns:
            A status constant of this module.
        """
        vectors = [np.ascontiguousarray(v, dtype=np.float64) for v in (low, high, c, p, first)]
        low_, high_, *others = (vector.ctypes.data for vector in vectors)
        status: int = library().minimize_largest(self._handle, _Box(low_, high_), *others)
        return status
