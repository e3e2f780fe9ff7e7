"""Binding of the C core."""

from __future__ import annotations

import ctypes
import os
import struct
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import CardsflowError, InputError
from addin_sdfusion.robot.model.laws import LAW_NAMES

from .arrays import FloatArray, IntArray

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
_HEADER = struct.Struct("<IIIIQ")
_MAGIC = {False: 0x45524F43, True: 0x66524F43}
"""First word of the header of a blob, by whether its numbers have single precision."""

_REAL: dict[bool, np.dtype[Any]] = {False: np.dtype("<f8"), True: np.dtype("<f4")}


@cache
def library() -> ctypes.PyDLL:
    """Load and return the C core.

    Calls hold Python's global interpreter lock, since they take microseconds.

    Raises:
        CardsflowError: The library is missing or was compiled with other muscle laws.
    """
    root = Path(os.environ.get("CARDSFLOW_LIBRARY_DIR", Path(__file__).parents[2]))
    path = root / "sim_dart" / "lib" / f"cardsflow_core{_SUFFIX}"
    if not path.is_file():
        raise CardsflowError(f"{path}: the C core is missing; reinstall cardsflow to compile it")
    core = ctypes.PyDLL(str(path))
    pointer, size = ctypes.c_void_p, ctypes.c_size_t
    core.core_layout.restype = core.core_laws.restype = ctypes.c_char_p
    if core.core_laws().decode() != LAW_NAMES:
        raise CardsflowError(f"{path}: compiled with other muscle laws; reinstall cardsflow")
    core.core_layout_hash.restype = core.core_version.restype = ctypes.c_uint32
    core.core_size.argtypes = [pointer, size, ctypes.c_char_p, size]
    core.core_size.restype = size
    core.core_open.argtypes = [pointer, size, pointer]
    core.core_open.restype = pointer
    core.core_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(size)]
    core.core_array.restype = ctypes.POINTER(ctypes.c_double)
    without_answer = "move task_jacobian task_bias mass_matrix coriolis gravity accelerate trace"
    without_answer += " closures close_rates rates reach energies"
    without_answer += " independent_rows independent_bias independent_mass complete"
    for name in without_answer.split():
        getattr(
            core, f"core_{name}"
        ).restype = None  # attribute access caches the function, an index does not
    text, double, count = ctypes.c_char_p, ctypes.c_double, ctypes.c_int32
    for name in ("step", "runge_kutta"):
        getattr(core, f"core_{name}").argtypes = [pointer, text, text, double, count]
    core.core_external_wrenches.argtypes = [pointer, count, pointer, pointer, pointer]
    core.core_closures.argtypes = [pointer, text]
    core.core_free_motion.argtypes = [pointer, pointer, text]
    core.core_independent_rows.argtypes = [pointer, count, pointer]
    core.core_independent_bias.argtypes = [pointer, count, pointer, pointer]
    core.core_independent_mass.argtypes = [pointer, pointer, pointer]
    core.core_complete.argtypes = [pointer, pointer]
    core.core_close.argtypes = [pointer, pointer, pointer]
    core.core_close_rates.argtypes = [pointer, pointer]
    core.core_slide.argtypes = [pointer, text]
    core.core_pulling.argtypes = [pointer]
    core.core_trace.argtypes = [pointer]
    core.core_lines.argtypes = [pointer, pointer, pointer, count]
    core.core_reach.argtypes = [pointer, double]
    core.core_advance.argtypes = [pointer, text, double]
    core.core_invert.argtypes = [pointer, text, double, double]
    for name in ("fibres", "tendons"):
        getattr(core, f"core_{name}").argtypes = [pointer, count, pointer, pointer]
        getattr(core, f"core_{name}").restype = None
    return core


def _pad(packed: bytes) -> bytes:
    return packed + b"\0" * (-len(packed) % 8)


def _real_numbers(name: str, values: FloatArray, single: bool) -> NDArray[Any]:
    """Return values in the number format of a blob."""
    with np.errstate(over="ignore"):
        packed: NDArray[Any] = values.astype(_REAL[single])
    lost = np.isfinite(values) & ~np.isfinite(packed)
    if lost.any():
        raise CardsflowError(
            f"{name}: {float(values[lost][0])!r} is too large for single precision"
        )
    return packed


def pack_field(name: str, values: NDArray[Any], size: int) -> bytes:
    """Return the numbers of a field as bytes, padded to a multiple of 8.

    Args:
        name: Name of the field, for messages.
        values: Its numbers, of any shape.
        size: Required number of values.
    """
    assert values.size == size, name
    return _pad(values.tobytes())


def pack_blob(
    counts: Mapping[str, int], fields: Mapping[str, ArrayLike], *, single: bool = False
) -> bytes:
    """Pack the numbers of a robot according to the layout that the library reports.

    Args:
        counts: Number of coordinates, muscles, points and task frames by name.
        fields: An array for every field, of any shape with the right number of elements.
        single: Use single precision, for a core compiled with `CARDSFLOW_FLOAT`.

    Raises:
        CardsflowError: A number is too large for single precision.
    """
    sizes: list[int] = []
    body = b""
    for line in library().core_layout().decode().splitlines():
        kind, name, *rest = line.split()
        if kind == "count":
            sizes.append(counts[name])
            continue
        values = np.asarray(fields[name])
        is_real = kind == "real"
        values = (
            _real_numbers(name, values.astype(float), single) if is_real else values.astype("<i4")
        )
        body += pack_field(name, values, int(rest[0]) * counts[rest[1]])
    numbers = _pad(struct.pack(f"<{len(sizes)}i", *sizes))
    size = _HEADER.size + len(numbers) + len(body)
    core = library()
    return (
        _HEADER.pack(_MAGIC[single], core.core_version(), core.core_layout_hash(), 0, size)
        + numbers
        + body
    )


def blob_reals(blob: bytes) -> FloatArray:
    """Return the real numbers of a double-precision blob in the order of its fields, shape (k,)."""
    fields = blob_fields(blob).values()
    return np.concatenate(
        [np.frombuffer(blob, "<f8", size, at) for at, size, kind in fields if kind == "real"]
    )


def blob_fields(blob: bytes) -> dict[str, tuple[int, int, str]]:
    """Return offset, number of elements and type of each field of a double-precision blob."""
    lines = [line.split() for line in library().core_layout().decode().splitlines()]
    names = [name for kind, name, *_ in lines if kind == "count"]
    counts = dict(
        zip(names, struct.unpack_from(f"<{len(names)}i", blob, _HEADER.size), strict=True)
    )
    at, fields = _HEADER.size + len(_pad(bytes(4 * len(names)))), {}
    for kind, name, *rest in lines:
        if kind == "count":
            continue
        size = int(rest[0]) * counts[rest[1]]
        fields[name] = at, size, kind
        at += len(_pad(bytes((8 if kind == "real" else 4) * size)))
    return fields


class Core:
    """Instance of a robot in the C core.

    The functions of the library are attributes: `move` calls core_move, `update_gravity` calls
    core_gravity. Pass `handle` as first argument, and arrays as bytes (`array.tobytes()`), which is
    the fastest way to pass them.

    Args:
        blob: From `pack_blob`.

    Raises:
        InputError: The library rejects the blob.

    Attributes:
        handle: First argument of every call.
        blob: The blob, as numbers of 8 bytes.
        memory: The working memory, as numbers of 8 bytes.
    """

    def __init__(self, blob: bytes) -> None:
        core = library()
        self.blob = np.frombuffer(_pad(blob), dtype=np.float64).copy()
        address = self.blob.ctypes.data
        message = ctypes.create_string_buffer(256)
        size = core.core_size(address, len(blob), message, len(message))
        if not size:
            raise InputError(f"the C core rejects the robot: {message.value.decode()}")
        self.memory = np.empty((size + 7) // 8)
        self.handle = ctypes.c_void_p(core.core_open(address, len(blob), self.memory.ctypes.data))

    def __getattr__(self, name: str) -> Any:
        function = getattr(library(), f"core_{name.removeprefix('update_')}")
        setattr(self, name, function)  # later look-ups do not call __getattr__
        return function

    def external_wrenches(self, frames: IntArray, points: FloatArray) -> FloatArray:
        """Register points of moving frames on which external wrenches act in every later step.

        Args:
            frames: Index of the frame of each point, shape (k,); -1 for the world.
            points: Positions of the points in their frames, shape (k, 3), in [m].

        Returns:
            Force and moment on each point, world axes, shape (k, 6), in [N] and [N·m]. The array is
            initially zero and can be written at any time between steps.
        """
        wrenches = np.zeros((len(frames), 6))
        self._wrenched = frames.astype(np.int32), np.array(points, dtype=np.float64), wrenches
        addresses = (array.ctypes.data for array in self._wrenched)
        bad = library().core_external_wrenches(self.handle, len(frames), *addresses)
        assert not bad, frames
        return wrenches

    def array(self, name: str, *shape: int) -> FloatArray:
        """Return a result array as a view of the given shape. Later calls change its values."""
        length = ctypes.c_size_t()
        pointer = library().core_array(self.handle, name.encode(), ctypes.byref(length))
        assert pointer, name
        if not length.value:
            return np.empty(shape)
        # a slice of the memory object keeps this alive as long as any view exists
        address = ctypes.cast(pointer, ctypes.c_void_p).value or 0
        first = (address - self.memory.ctypes.data) // self.memory.itemsize
        return self.memory[first : first + length.value].reshape(shape)
