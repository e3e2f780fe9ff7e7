"""Binding of the control loop in C, with a law and dynamics in Python; see csrc/loop."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, Protocol

import numpy as np

from controllers.arrays import FloatArray
from controllers.qp import dual_newton, law_in_c

_P = ctypes.c_void_p
_CFUNC = ctypes.PYFUNCTYPE
_TERMS = _CFUNC(None, _P, _P, _P, _P, _P, _P)
_COMPLETE = _CFUNC(None, _P, _P, _P, _P)
_SOLVE = _CFUNC(ctypes.c_int, _P, _P, _P, _P, _P, _P, _P, _P)
_ERROR = _CFUNC(None, _P, _P, _P, _P)


class _Robot(ctypes.Structure):
    """The C structure `control_robot` in control_loop.h."""

    _fields_ = (
        ("self", _P),
        ("terms", _TERMS),
        ("tasks", _P),
        ("complete", _COMPLETE),
        ("dependent", _P),
        ("gravity", _P),
    )


class _Law(ctypes.Structure):
    """The C structure `control_law` in control_loop.h."""

    _fields_ = (("self", _P), ("torque", _P), ("solve", _SOLVE), ("error", _ERROR))


class LoopCallbacks(Protocol):
    """Callbacks of the loop in C; see `ControlLoop`."""

    law: Any

    def terms(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return M, h and L."""

    def solve(
        self, q: FloatArray, qd: FloatArray, reference: FloatArray, load: FloatArray
    ) -> tuple[int, FloatArray, FloatArray]:
        """Solve the law and return status, forces and slack."""


@cache
def _library() -> ctypes.PyDLL:
    loops = law_in_c.library()
    size, integer = ctypes.c_size_t, ctypes.c_int
    loops.control_loop_size.argtypes = [integer, integer, integer]
    loops.control_loop_size.restype = size
    loops.control_loop_open.argtypes = [_P, integer, integer, integer, _P]
    loops.control_loop_open.restype = _P
    loops.control_loop_set_law.argtypes = [_P, _P]
    loops.control_loop_array.argtypes = [_P, ctypes.c_char_p, ctypes.POINTER(size)]
    loops.control_loop_array.restype = _P
    loops.control_loop_tick.argtypes = [_P, ctypes.c_double, _P, _P, _P, _P]
    return loops


class LoopInC(law_in_c.NamedArrays):
    """Control loop in C for n coordinates, m actuators and r reference coordinates.

    `loop[name]` is the array of this name in control_loop.h.
    """

    def __init__(self, n: int, m: int, r: int, callbacks: LoopCallbacks) -> None:
        self._n, self._m, self._r, self._callbacks = n, m, r, callbacks
        self._library = loops = _library()
        sizes = n, m, 0 if r == n else r
        self._memory = np.zeros(-(-loops.control_loop_size(*sizes) // 8))
        robot = callbacks.law.dynamics
        dependent = getattr(robot, "dependent", None)
        self._dependent = None if dependent is None else np.asarray(dependent, dtype=np.float64)
        has_loops = hasattr(robot, "complete")
        self._robot = _Robot(
            None,
            _TERMS(self._terms),
            None,
            _COMPLETE(self._complete) if has_loops else _COMPLETE(),
            None if self._dependent is None else self._dependent.ctypes.data,
            None,
        )
        self._law = _Law(None, None, _SOLVE(self._solve), _ERROR(self._error))
        address = self._memory.ctypes.data
        handle = loops.control_loop_open(ctypes.byref(self._robot), *sizes, address)
        super().__init__(loops.control_loop_array, handle)
        loops.control_loop_set_law(self.handle, ctypes.byref(self._law))
        self._views: dict[tuple[int, int], FloatArray] = {}
        self._q, self._qd, self._load = np.zeros(n), np.zeros(n), np.zeros(n)
        self._reference = np.zeros((3, r))
        inputs = self._q, self._qd, self._reference, self._load
        self._addresses = [values.ctypes.data for values in inputs]
        self._failure: BaseException | None = None

    def tick(
        self, period: float, q: FloatArray, qd: FloatArray, reference: FloatArray, load: FloatArray
    ) -> None:
        """Execute one tick; raises errors of the law and of the dynamics."""
        self._q[:], self._qd[:], self._reference[:], self._load[:] = q, qd, reference, load
        self._failure = None
        self._library.control_loop_tick(self.handle, period, *self._addresses)
        if self._failure is not None:
            raise self._failure

    def _view(self, address: int, length: int) -> FloatArray:
        """Return a cached view of memory of the loop, whose address does not change."""
        view = self._views.get((address, length))
        if view is None:
            view = self._views[address, length] = dual_newton.view(address, length)
        return view

    def _read(self, address: int, length: int) -> FloatArray:
        return self._view(address, length).copy()

    def _terms(self, _: Any, q: int, qd: int, M: int, h: int, L: int) -> None:
        n, m = self._n, self._m
        try:
            terms = self._callbacks.terms(self._read(q, n), self._read(qd, n))
            for address, size, values in zip((M, h, L), (n * n, n, m * n), terms, strict=True):
                self._view(address, size)[:] = np.ravel(values)
        except BaseException as failure:
            self._failure = self._failure or failure

    def _complete(self, _: Any, q: int, qd: int, qdd: int) -> None:
        n = self._n
        try:
            completed = self._view(qdd, n)
            robot = self._callbacks.law.dynamics
            completed[:] = robot.complete(self._read(q, n), self._read(qd, n), completed.copy())
        except BaseException as failure:
            self._failure = self._failure or failure

    def _solve(
        self, _: Any, q: int, qd: int, reference: int, _c: int, load: int, forces: int, slack: int
    ) -> int:
        n, r = self._n, self._r
        if self._failure is not None:
            return law_in_c.FAILED
        try:
            desired = self._read(reference, 3 * r).reshape(3, r)
            state = self._read(q, n), self._read(qd, n)
            status, solution, missing = self._callbacks.solve(*state, desired, self._read(load, n))
            self._view(forces, self._m)[:] = solution
            self._view(slack, r)[:] = missing
        except BaseException as failure:
            self._failure = failure
            return law_in_c.FAILED
        return status

    def _error(self, _: Any, q: int, position: int, error: int) -> None:
        try:
            at, goal = self._read(q, self._n), self._read(position, self._r)
            self._view(error, self._r)[:] = self._callbacks.law.error(at, goal)
        except BaseException as failure:
            self._failure = self._failure or failure
