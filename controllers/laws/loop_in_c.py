"""Binding of the control loop in C, with a law and dynamics in Python; see csrc/loop."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from controllers.arrays import FloatArray
from controllers.dynamics import Dynamics, actuator_names, bias_torque
from controllers.force_distribution.solution import STATUSES, ForceSolution
from controllers.qp import dual_newton, law_in_c

_P = ctypes.c_void_p
_TERMS = ctypes.CFUNCTYPE(None, *[_P] * 6)
_COMPLETE = ctypes.CFUNCTYPE(None, *[_P] * 4)
_SOLVE = ctypes.CFUNCTYPE(ctypes.c_int, *[_P] * 8)
_ERROR = ctypes.CFUNCTYPE(None, *[_P] * 4)


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


class LawStructure(ctypes.Structure):
    """The C structure `control_law` in control_loop.h."""

    _fields_ = (("self", _P), ("torque", _P), ("solve", _SOLVE), ("error", _ERROR))


class Callbacks:
    """Python functions that C calls, for one object in C."""

    def __init__(self) -> None:
        self._views: dict[tuple[int, int], FloatArray] = {}
        self._raised: BaseException | None = None

    def guard(self, function: Callable[..., Any], failed: int | None = None) -> Callable[..., Any]:
        """Return the function with a first argument `self`, which is not used.

        An exception is stored, since it must not propagate through C. Then this call and all
        others until `raise_stored` return `failed`.
        """

        def call(_: int | None, *arguments: int) -> Any:
            if self._raised is None:
                try:
                    return function(*arguments)
                except BaseException as error:
                    self._raised = error
            return failed

        return call

    def raise_stored(self) -> None:
        """Raise the exception of a function that C called, if there is one."""
        raised, self._raised = self._raised, None
        if raised is not None:
            raise raised

    def view(self, address: int, length: int) -> FloatArray:
        """Return a cached view of memory of the object in C, whose address does not change."""
        view = self._views.get((address, length))
        if view is None:
            view = self._views[address, length] = dual_newton.view(address, length)
        return view

    def read(self, address: int, length: int) -> FloatArray:
        """Return a copy of C memory."""
        return self.view(address, length).copy()

    def law(
        self,
        sizes: tuple[int, int, int],
        solve: Callable[..., ForceSolution],
        error: Callable[[FloatArray, FloatArray], FloatArray],
    ) -> LawStructure:
        """Return the C structure of a law with the methods `solve` and `error` of `ControlLaw`.

        Args:
            sizes: Numbers of coordinates, actuators and reference coordinates.
        """
        n, a, r = sizes
        view, read = self.view, self.read

        def call_solve(
            q: int, qd: int, reference: int, correction: int, load: int, forces: int, slack: int
        ) -> int:
            state = read(q, n), read(qd, n), *read(reference, 3 * r).reshape(3, r)
            solution = solve(*state, w_e=read(load, n), correction=read(correction, r))
            view(forces, a)[:] = solution.forces
            view(slack, r)[:] = solution.slack
            return STATUSES.index(solution.status)

        def call_error(q: int, position: int, result: int) -> None:
            view(result, r)[:] = error(read(q, n), read(position, r))

        guarded = self.guard(call_solve, law_in_c.FAILED)
        return LawStructure(solve=_SOLVE(guarded), error=_ERROR(self.guard(call_error)))


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
    """Control loop in C; `loop[name]` is the array of this name in control_loop.h.

    Args:
        r: Number of reference coordinates.
        callbacks: The object that created the law.
    """

    def __init__(self, robot: Dynamics, r: int, callbacks: Callbacks, law: LawStructure) -> None:
        n, m = len(robot.coordinate_names), len(actuator_names(robot))
        self._callbacks, self._law, self._library = callbacks, law, _library()
        sizes = n, m, 0 if r == n else r
        self._memory = np.zeros(-(-self._library.control_loop_size(*sizes) // 8))
        dependent = getattr(robot, "dependent", None)
        self._dependent = None if dependent is None else np.asarray(dependent, dtype=np.float64)
        view, read = callbacks.view, callbacks.read

        def terms(q: int, qd: int, M: int, h: int, L: int) -> None:
            at, rates = read(q, n), read(qd, n)
            view(M, n * n)[:] = np.ravel(robot.mass_matrix(at))
            view(h, n)[:] = bias_torque(robot, at, rates)
            view(L, m * n)[:] = np.ravel(robot.actuator_jacobian(at))

        def complete(q: int, qd: int, qdd: int) -> None:
            view(qdd, n)[:] = with_loops(read(q, n), read(qd, n), read(qdd, n))

        with_loops: Any = getattr(robot, "complete", None)
        self._robot = _Robot(
            terms=_TERMS(callbacks.guard(terms)),
            complete=_COMPLETE(callbacks.guard(complete)) if with_loops else _COMPLETE(),
            dependent=None if self._dependent is None else self._dependent.ctypes.data,
        )
        address = self._memory.ctypes.data
        handle = self._library.control_loop_open(ctypes.byref(self._robot), *sizes, address)
        super().__init__(self._library.control_loop_array, handle)
        self._library.control_loop_set_law(self.handle, ctypes.byref(law))

    def tick(self, period: float, *inputs: FloatArray) -> None:
        """Execute one tick; raises errors of the law and of the dynamics.

        Args:
            inputs: q, qd, reference and load.
        """
        rows = [np.ascontiguousarray(values, dtype=np.float64) for values in inputs]
        self._library.control_loop_tick(self.handle, period, *(row.ctypes.data for row in rows))
        self._callbacks.raise_stored()
