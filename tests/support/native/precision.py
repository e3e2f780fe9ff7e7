"""Core and laws as a library for this machine, in single or double precision.

The libraries of the package use doubles. Tests compile the same sources for both precisions.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import Robot
from sim_dart import compile_blob

from .targets import FLAGS, GCC, PROGRAMS, ROOT, SOURCES, compiled, require, run, single_flags

Array = NDArray[Any]

STRICT = ("-Wdouble-promotion", "-Wfloat-conversion")
"""Compiler flags that reject implicit doubles and narrowing conversions."""

_ANSWERS_SIZE = ("core_size", "dual_newton_size", "computed_torque_size", "control_loop_size")
_ANSWERS_POINTER = [
    f"{prefix}_{name}"
    for prefix in ("core", "dual_newton", "computed_torque")
    for name in ("open", "array")
]


class Precision:
    """Library that is compiled in a folder with further sources and flags, and its number type."""

    def __init__(
        self, folder: Path, single: bool, sources: Sequence[str] = (), flags: Sequence[str] = ()
    ) -> None:
        require(GCC)
        self.single, self.dtype = single, np.dtype(np.float32 if single else np.float64)
        self.number = ctypes.c_float if single else ctypes.c_double
        target = folder / f"core_{self.dtype}.so"
        files = [PROGRAMS / name for name in sources]
        headers = [f"-I{ROOT}", f"-I{folder}"]
        own = (*single_flags(GCC), *STRICT) if single else ()
        shared = [*FLAGS, *own, *flags]
        command = [*GCC.compiler, *shared, *headers, "-shared", *map(str, files)]
        run([*command, *compiled(GCC, shared, SOURCES), "-o", str(target), "-lm"])
        self.library = ctypes.CDLL(str(target))
        for name in _ANSWERS_SIZE:
            getattr(self.library, name).restype = ctypes.c_size_t
        for name in _ANSWERS_POINTER:
            getattr(self.library, name).restype = ctypes.c_void_p

    def numbers(self, values: ArrayLike) -> Array:
        """Return values as an array of the number type of the library."""
        return np.ascontiguousarray(values, dtype=self.dtype)

    def view(self, address: int | None, length: int) -> Array:
        """Return a view of memory of the library."""
        assert address
        kind = self.number * length
        return np.frombuffer(kind.from_address(address), self.dtype)

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function with arrays as addresses, and floats as numbers of the library."""
        function: Any = getattr(self.library, name)
        return int(function(*map(self._argument, arguments)) or 0)

    def _argument(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return ctypes.c_void_p(value.ctypes.data)
        if isinstance(value, bytes):
            return ctypes.c_char_p(value)
        if isinstance(value, float):
            return self.number(value)
        return value


class Handle:
    """Handle of the library, with the prefix of its functions."""

    def __init__(self, precision: Precision, prefix: str, pointer: int) -> None:
        assert pointer, prefix
        self.precision, self.prefix = precision, prefix
        self.pointer = ctypes.c_void_p(pointer)

    def array(self, name: str) -> Array:
        """Return a view of an array of the handle."""
        length = ctypes.c_size_t()
        find: Any = getattr(self.precision.library, f"{self.prefix}_array")
        address = find(self.pointer, name.encode(), ctypes.byref(length))
        return self.precision.view(address, length.value)

    def call(self, name: str, *arguments: Any) -> int:
        """Call a function of the handle."""
        return self.precision.call(f"{self.prefix}_{name}", self.pointer, *arguments)


def room(size: int) -> Array:
    """Return memory with the alignment of the handles."""
    return np.zeros(-(-size // 8), dtype=np.uint64)


def open_robot(precision: Precision, robot: Robot) -> Handle:
    """Open a robot in a core of that precision."""
    blob = np.frombuffer(compile_blob(robot, single=precision.single), np.uint64).copy()
    message = ctypes.create_string_buffer(256)
    size = precision.call("core_size", blob, blob.nbytes, message, len(message))
    assert size, message.value
    memory = room(size)
    pointer = precision.call("core_open", blob, blob.nbytes, memory)
    handle = Handle(precision, "core", pointer)
    handle.memory = blob, memory  # type: ignore[attr-defined]
    return handle


def open_program(precision: Precision, n: int, rows: int) -> Handle:
    """Open a QP solver for problems of a given size."""
    memory = room(precision.call("dual_newton_size", n, rows))
    pointer = precision.call("dual_newton_open", n, rows, memory)
    handle = Handle(precision, "dual_newton", pointer)
    handle.memory = memory  # type: ignore[attr-defined]
    return handle
