"""Binding of the control laws in C; see csrc/laws/computed_torque.h."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import CardsflowError, InputError
from controllers.arrays import FloatArray

from . import dual_newton
from . import solver as qp

if TYPE_CHECKING:
    import qpsolvers

SOLVED, SOFT, NOT_CONVERGED, FAILED, WRONG, NEXT = range(6)
GIVEN = -1
"""Value of the array `law` that selects the torque in the array `tau`."""


@cache
def library() -> ctypes.PyDLL:
    """Load the library of the control laws; calls do not release the Python lock (GIL)."""
    laws = dual_newton.library()
    pointer, size, integer = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int
    laws.computed_torque_law.argtypes = [ctypes.c_char_p]
    laws.computed_torque_size.argtypes = [integer, integer, integer]
    laws.computed_torque_size.restype = size
    laws.computed_torque_open.argtypes = [integer, integer, integer, pointer]
    laws.computed_torque_open.restype = pointer
    laws.computed_torque_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
    laws.computed_torque_array.restype = pointer
    for name in ("needs_gravity", "reset", "require", "solve", "build", "program"):
        getattr(laws, f"computed_torque_{name}").argtypes = [pointer]
    laws.computed_torque_program.restype = pointer
    laws.computed_torque_finish.argtypes = [pointer, pointer]
    return laws


def number_of(law: str) -> int:
    """Return the number of a joint-space law in `JOINT_LAWS`, for the array `law`.

    Raises:
        CardsflowError: The library was compiled from another table.
    """
    number: int = library().computed_torque_law(law.encode())
    if number < 0:
        raise CardsflowError(
            f"the C library has no control law {law!r}; reinstall cardsflow to compile it"
        )
    return number


class NamedArrays:
    """Arrays of a C object as views of its memory: `arrays[name]`."""

    def __init__(self, find: Any, handle: int, **shapes: tuple[int, ...]) -> None:
        self._find, self.handle, self._shapes = find, ctypes.c_void_p(handle), shapes
        self._arrays: dict[str, FloatArray] = {}

    def __getitem__(self, name: str) -> FloatArray:
        array = self._arrays.get(name)
        if array is None:
            array = dual_newton.array_of(self._find, self.handle, name)
            self._arrays[name] = array = array.reshape(self._shapes.get(name, -1))
        return array

    def write(self, **arrays: ArrayLike | None) -> None:
        """Write arrays by name; numpy broadcasts the values, and None writes 0."""
        for name, values in arrays.items():
            self[name][...] = 0.0 if values is None else values

    def restore(self, name: str, state: ArrayLike, owner: str) -> None:
        """Write an array with the state of an object, which is named in messages.

        Raises:
            InputError: The state has another length, or is not finite.
        """
        memory = self[name]
        if np.shape(state) != memory.shape or not np.isfinite(state).all():
            raise InputError(f"the state of the {owner} must be {memory.size} finite numbers")
        memory[:] = state


class LawInC(NamedArrays):
    """Control law in C for n coordinates, m actuators and k task coordinates.

    k is 0 for laws in joint space. `law[name]` is the array of this name in computed_torque.h.
    """

    def __init__(self, n: int, m: int, k: int = 0) -> None:
        laws = library()
        self._memory = np.zeros(-(-laws.computed_torque_size(n, m, k) // 8))
        handle = laws.computed_torque_open(n, m, k, self._memory.ctypes.data)
        super().__init__(laws.computed_torque_array, handle, M=(n, n), L=(m, n), J=(k, n))
        self._library = laws
        self._programs: dict[int, dual_newton.DualNewton] = {}

    def reset(self) -> None:
        """Discard the results of previous calls."""
        self._library.computed_torque_reset(self.handle)

    @property
    def needs_gravity(self) -> bool:
        """Whether the selected joint-space law uses G."""
        return bool(self._library.computed_torque_needs_gravity(self.handle))

    def required_torque(self) -> FloatArray:
        """Return the torque of the joint-space law, shape (n,), in [N·m] or [N]."""
        self._library.computed_torque_require(self.handle)
        return self["tau"].copy()

    def solve(self, solver: str = qp.DEFAULT_SOLVER) -> int:
        """Solve by a back end, or in C if the back end fails, and return a status."""
        if solver != qp.DUAL_NEWTON:
            status = self._solve_by(solver)
            if status < FAILED:
                return status
        status = self._library.computed_torque_solve(self.handle)
        return int(status)

    def _solve_by(self, solver: str) -> int:
        status: int = self._library.computed_torque_build(self.handle)
        if status == WRONG:
            return status
        status = NEXT
        while status == NEXT:
            x = qp.solve(self._program(), solver)
            if x is None:
                return FAILED
            x = np.ascontiguousarray(x, dtype=np.float64)
            status = self._library.computed_torque_finish(self.handle, x.ctypes.data)
        return status

    def build(self) -> qpsolvers.Problem:
        """Return the QP for qpsolvers, with an additional variable after f for each soft row."""
        self._library.computed_torque_build(self.handle)
        return self._program()

    def _program(self) -> qpsolvers.Problem:
        address = self._library.computed_torque_program(self.handle)
        if address not in self._programs:
            self._programs[address] = dual_newton.DualNewton.at(address)
        return qp.as_qpsolvers(self._programs[address])
