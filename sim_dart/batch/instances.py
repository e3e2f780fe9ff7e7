"""Memory of many instances of a robot in the C core."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, library
from sim_dart.core.mass_check import require_inertia
from sim_dart.muscles.laws import MuscleLaws
from sim_dart.plant.settings import unsupported_by_core

from .binding import batch_library

_LINE = 8  # numbers in a cache line, which two threads must not share


class Instances:
    """Working memory of n instances, one row each, and the robots that they can have.

    Args:
        variants: Robots that differ only in numbers, such as masses, points and parameters.
        n: Number of instances. Instance i begins with variant i modulo the number of variants.

    Raises:
        RobotError: A robot is not valid.
        InputError: The C core does not support a robot, or a robot differs in more than numbers.

    Attributes:
        memory: The working memory, shape (n, k).
        laws: Muscle laws of every variant.
        variant: Index of the variant of every instance, shape (n,).
    """

    def __init__(self, variants: Sequence[Robot], n: int) -> None:
        self.cores = [_open_core(robot) for robot in variants]
        self.laws = [MuscleLaws(*pair) for pair in zip(variants, self.cores, strict=True)]
        first = self.cores[0]
        for robot, core in zip(variants, self.cores, strict=True):
            _require_same_structure(variants[0], first, robot, core)
        width = -(-first.memory.size // _LINE) * _LINE
        block = np.zeros(n * width + _LINE)
        shift = -block.ctypes.data // 8 % _LINE
        self.memory: FloatArray = block[shift : shift + n * width].reshape(n, width)
        self._start, self._stride = int(self.memory.ctypes.data), int(self.memory.strides[0])
        self.variant: IntArray = np.zeros(n, dtype=np.int32)
        for i in range(n):
            self.open(i, i % len(variants))

    def open(self, i: int, variant: int) -> None:
        """Make an instance a robot of a variant, in a state of zeros."""
        blob = self.cores[variant].blob
        opened = library().core_open(blob.ctypes.data, blob.nbytes, self.address(i))
        assert opened == self.address(i)
        self.variant[i] = variant

    def address(self, i: int) -> int:
        """Return the address of the handle of an instance."""
        return self._start + i * self._stride

    def group_memory(self, count: int) -> list[FloatArray]:
        """Return memory for threads to step several instances at once; empty if unsupported."""
        sizes = [batch_library().core_batch_group_size(core.handle) for core in self.cores]
        if not 0 < min(sizes) == max(sizes):
            return []
        return [np.zeros(sizes[0] // 8) for _ in range(count)]

    def place(self, part: slice) -> tuple[int, int, int]:
        """Return address, distance and number of the handles of a part."""
        return self.address(part.start), self._stride, part.stop - part.start

    def columns(self, name: str) -> range:
        """Return the columns of a result array in the working memory."""
        core, length = self.cores[0], ctypes.c_size_t()
        pointer = library().core_array(core.handle, name.encode(), ctypes.byref(length))
        at = (ctypes.cast(pointer, ctypes.c_void_p).value or 0) - core.memory.ctypes.data
        first = at // core.memory.itemsize if length.value else 0
        return range(first, first + length.value)

    def view(self, name: str, *shape: int) -> FloatArray:
        """Return a result array of all instances, shape (n, *shape), as a view."""
        columns = self.columns(name)
        if not columns:
            return np.empty((len(self.memory), *shape))
        part = self.memory[:, columns.start : columns.stop]
        return part.reshape(len(part), *shape)  # splits the last axis, which needs no copy

    def resting_commands(self, variant: int, q: FloatArray, tensions: FloatArray) -> FloatArray:
        """Return the commands with which the muscles of a variant hold tensions at rest."""
        core, laws = self.cores[variant], self.laws[variant]
        core.move(core.handle, q.tobytes())
        return laws.resting_commands(tensions)


def _open_core(robot: Robot) -> Core:
    require_valid(robot)
    unsupported = unsupported_by_core(None, robot)
    if unsupported is not None:
        raise InputError(f"batches do not support {unsupported}; use Plant")
    core, n = Core(compile_blob(robot)), len(robot.coordinates)
    initial = np.array([coordinate.initial for coordinate in robot.coordinates])
    core.move(core.handle, initial.tobytes())
    core.update_mass_matrix(core.handle)
    require_inertia(robot, core.array("mass_matrix", n, n))
    return core


def _require_same_structure(first: Robot, core: Core, robot: Robot, other: Core) -> None:
    names = [[c.name for c in r.coordinates] + [m.name for m in r.muscles] for r in (first, robot)]
    laws = [MuscleLaws(first, core).state_names, MuscleLaws(robot, other).state_names]
    if names[0] != names[1] or laws[0] != laws[1] or core.memory.size != other.memory.size:
        raise InputError(
            f"variant {robot.name!r}: coordinates, muscles and muscle laws must be the same as in "
            "the first variant; change only numbers"
        )
