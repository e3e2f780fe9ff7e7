"""Replays a file of vectors through the package's libraries, as replay_vectors.c does in C."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from controllers.qp.dual_newton import library as control_library
from sim_dart.core.library import Core
from sim_dart.core.library import library as core_library

from .vector_file import HEAD

FloatArray = NDArray[np.float64]
_NUMBERS = ctypes.POINTER(ctypes.c_double)
_TERMS = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *[_NUMBERS] * 5)
_TASKS = ctypes.CFUNCTYPE(None, ctypes.c_void_p, *[_NUMBERS] * 6)


class _ControlRobot(ctypes.Structure):
    _fields_ = [("self", ctypes.c_void_p), ("terms", _TERMS), ("tasks", _TASKS)]


class _Handle:
    """A handle of the control library, by the prefix of its functions."""

    def __init__(self, prefix: str, address: int | None) -> None:
        assert address, prefix
        self.pointer = ctypes.c_void_p(address)
        self._find = control_library()[f"{prefix}_array"]
        self._find.restype = _NUMBERS

    def array(self, name: str) -> FloatArray:
        """A view."""
        length = ctypes.c_size_t()
        found = self._find(self.pointer, name.encode(), ctypes.byref(length))
        return _view(found, length.value)


class _Replay:
    """Robot, program and loop that the records speak of."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.failed: list[str] = []
        self._memory: list[FloatArray] = []
        self._handles: dict[str, _Handle] = {}

    def robot(self, values: FloatArray) -> None:
        self._core = core = Core(values.tobytes())
        self._n = core.array("q", -1).size
        self._m = core.array("lengths", -1).size
        field = core_library()["core_coordinates"]
        field.restype = _NUMBERS
        self._damping = _view(field(core.handle, b"damping"), self._n)

    def state(self, values: FloatArray) -> None:
        q, qd, f = (part.tobytes() for part in np.split(values, [self._n, 2 * self._n]))
        core, handle = self._core, self._core.handle
        assert not core.move_checked(handle, q, qd)
        assert not core.pull(handle, f)
        core.update_task_jacobian(handle)
        core.update_task_bias(handle, qd)
        core.update_mass_matrix(handle)
        core.update_gravity(handle)
        core_library().core_bias(handle, qd)
        tau = core.array("torques", -1).tobytes()
        core.accelerate(handle, qd, tau, bytes(len(qd)))

    def program(self, values: FloatArray) -> None:
        solver, sizes = control_library(), [int(value) for value in values]
        memory = self._room(solver.dual_newton_size(*sizes))
        self._handles["program"] = _Handle("dual_newton", solver.dual_newton_open(*sizes, memory))

    def solve(self, values: FloatArray) -> None:
        assert control_library().dual_newton_solve(self._handles["program"].pointer) == 0

    def loop(self, rows: FloatArray) -> None:
        library, sizes = control_library(), [self._n, self._m, rows.size]
        self._rows = rows.astype(int)
        self._callbacks = _ControlRobot(None, _TERMS(self._terms), _TASKS(self._tasks))
        library.control_loop_size.restype = ctypes.c_size_t
        library.control_loop_open.restype = ctypes.c_void_p
        library.control_loop_law.restype = ctypes.c_void_p
        memory = self._room(library.control_loop_size(*sizes))
        opened = library.control_loop_open(ctypes.byref(self._callbacks), *sizes, memory)
        loop = self._handles["loop"] = _Handle("control_loop", opened)
        law = library.control_loop_law(loop.pointer)
        self._handles["law"] = _Handle("computed_torque", law)

    def run(self, values: FloatArray) -> None:
        core, library, n, loop = self._core, control_library(), self._n, self._handles["loop"]
        period, step, steps = ctypes.c_double(values[0]), float(values[1]), int(values[2])
        q, qd = values[3 : 3 + n].copy(), values[3 + n : 3 + 2 * n].copy()
        rows = values[3 + 2 * n :].reshape(-1, 3 * (self._rows.size or n))
        acting, still = loop.array("acting"), bytes(8 * n)
        library.control_loop_reset(loop.pointer)
        positions, forces = [], []
        for row in rows:
            state = q.tobytes(), qd.tobytes(), row.tobytes(), still
            assert library.control_loop_tick(loop.pointer, period, *state) <= 1
            core.array("q", n)[:], core.array("qd", n)[:] = q, qd
            core.move(core.handle, q.tobytes())
            assert not core.step(core.handle, acting.tobytes(), None, step, steps)
            q[:], qd[:] = core.array("q", n), core.array("qd", n)
            positions.append(q.copy())
            forces.append(acting.copy())
        self._run = {"q": np.ravel(positions), "forces": np.ravel(forces)}

    def set(self, name: str, values: FloatArray) -> None:
        array = self._find(name)
        assert array.size == values.size, name
        array[:] = values

    def expect(self, name: str, values: FloatArray, tolerance: float) -> None:
        array = self._find(name)
        assert array.size == values.size, name
        worst = np.abs(array - values).max(initial=0.0)
        if not worst <= tolerance * np.abs(values).max(initial=0.0):
            self.failed.append(f"{name} is off by {worst}")
        self.lines.append(f"{_digest(array):016x} {name}")

    def _find(self, name: str) -> FloatArray:
        kind, array = name.split(".")
        if kind == "core":
            return self._core.array(array, -1)
        if kind == "run":
            return self._run[array]
        return self._handles[kind].array(array)

    def _room(self, size: int) -> Any:
        self._memory.append(np.empty((size + 7) // 8))
        return ctypes.c_void_p(self._memory[-1].ctypes.data)

    def _terms(self, _: Any, q: Any, qd: Any, M: Any, h: Any, L: Any) -> None:
        core, handle, n, m = self._core, self._core.handle, self._n, self._m
        core.move(handle, q)
        core.update_mass_matrix(handle)
        core_library().core_bias(handle, qd)
        _view(M, n * n)[:] = core.array("mass_matrix", -1)
        _view(L, m * n)[:] = core.array("jacobian", -1)
        _view(h, n)[:] = core.array("coriolis", n) + self._damping * _view(qd, n)

    def _tasks(self, _: Any, q: Any, qd: Any, goal: Any, error: Any, J: Any, bias: Any) -> None:
        core, handle, rows, n = self._core, self._core.handle, self._rows, self._n
        core.move(handle, q)
        core.update_task_jacobian(handle)
        core.update_task_bias(handle, qd)
        k = rows.size
        _view(error, k)[:] = _view(goal, k) - core.array("task_values", -1)[rows]
        _view(bias, k)[:] = core.array("task_bias", -1)[rows]
        _view(J, k * n)[:] = core.array("task_jacobian", -1, n)[rows].ravel()


def _view(pointer: Any, length: int) -> FloatArray:
    if not length:
        return np.empty(0)
    array: FloatArray = np.ctypeslib.as_array(pointer, (length,))
    return array


def _digest(values: FloatArray) -> int:
    """FNV-1a of the bits."""
    code = 14695981039346656037
    for byte in values.tobytes():
        code = (code ^ byte) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return code


def replay_vectors(path: Path) -> tuple[list[str], Sequence[str]]:
    """The lines that replay_vectors.c prints, and those that deviate too much."""
    contents, at, player = path.read_bytes(), 0, _Replay()
    while at < len(contents):
        padded, tolerance, count = HEAD.unpack_from(contents, at)
        values = np.frombuffer(contents, "<f8", count, at + HEAD.size)
        kind, _, name = padded.rstrip(b"\0").decode().partition(" ")
        at += HEAD.size + values.nbytes
        if kind == "expect":
            player.expect(name, values, tolerance)
        elif kind == "set":
            player.set(name, values)
        else:
            getattr(player, kind)(values)
    return player.lines, player.failed
