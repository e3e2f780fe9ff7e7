"""Roll-outs with exact derivatives by a robot's numbers, from the complex core."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import CardsflowError, Robot
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, blob_reals, library
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.muscles.friction import bends


@cache
def _bound() -> Any:
    core = ctypes.CDLL(library()._name)  # without Python's lock: windows take milliseconds each
    pointer, size, count = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int32
    core.core_sensitivity_numbers.argtypes = core.core_sensitivity_size.argtypes = [pointer]
    core.core_sensitivity_numbers.restype = core.core_sensitivity_size.restype = size
    core.core_sensitivity_open.argtypes = [pointer, pointer]
    core.core_sensitivity_open.restype = pointer
    core.core_sensitivity_roll.argtypes = [
        *(pointer, pointer, pointer, count, count, ctypes.c_double, pointer, pointer, count),
        *(pointer, pointer, pointer, pointer, pointer),
    ]
    return core


class Directions(NamedTuple):
    """What a roll-out is differentiated by, besides where it begins.

    Attributes:
        robot: How the robot's numbers change along each, shape (directions, numbers).
        changes: How tensions may change, shape (k, rows, m).
        commanded: Of each direction, which of these goes with it, or -1, shape (directions,).
    """

    robot: FloatArray
    changes: FloatArray
    commanded: IntArray


class Rolled(NamedTuple):
    """A roll-out.

    Attributes:
        readings: q and path lengths, shape (rows, n + m).
        derivatives: By the directions, then by q and qd at the start, shape (rows, n + m,
            directions + 2 n); no columns where there was nothing to differentiate by.
    """

    readings: FloatArray
    derivatives: FloatArray


def robot_numbers(robot: Robot) -> FloatArray:
    """Return the numbers of the blob that roll-outs work on, shape (numbers,)."""
    return blob_reals(compile_blob(estimated_robot(robot)))


class Sensitivity:
    """A robot that is pulled by tensions that were measured, with derivatives.

    Args:
        robot: The robot; its driven muscles pull with the tensions they are given.

    Raises:
        CardsflowError: This core has no derivatives.
    """

    def __init__(self, robot: Robot) -> None:
        self._core = Core(compile_blob(estimated_robot(robot)))
        self._c = _bound()
        size = self._c.core_sensitivity_size(self._core.handle)
        if not size:
            raise CardsflowError("this C core has no derivatives, which calibration requires")
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._bends = sum(map(bends, robot.muscles))
        self._memory = np.empty(-(-size // 8))
        address = self._memory.ctypes.data
        self._handle = ctypes.c_void_p(self._c.core_sensitivity_open(self._core.handle, address))

    def roll(
        self,
        start: FloatArray,
        tensions: FloatArray,
        torques: FloatArray,
        h: float,
        steps: int,
        along: Directions | None = None,
        slips: FloatArray | None = None,
    ) -> Rolled | None:
        """Roll through the readings of a window.

        Args:
            start: q and qd at the first reading, shape (2 n,).
            tensions: From each reading on, shape (rows, m), in [N].
            torques: Of motors at joints, shape (rows, n), in [N·m] or [N].
            h: Step, in [s].
            steps: Steps between two readings.
            along: What to differentiate by, besides the start; None for readings alone, in a small
                part of the time.
            slips: How cables with friction rub at the first reading, shape (bends,); neither way
                where left out.

        Returns:
            None if the state has diverged.
        """
        rows, width = len(tensions), self._n + self._m
        readings = np.empty((rows, width))
        start, tensions = np.ascontiguousarray(start), np.ascontiguousarray(tensions)
        torques, q = np.ascontiguousarray(torques), start.ctypes.data
        arrays = [] if along is None else [np.ascontiguousarray(array) for array in along]
        addresses = [array.ctypes.data for array in arrays] or [0] * len(Directions._fields)
        count = 0 if along is None else len(along.commanded)
        columns = 0 if along is None else count + 2 * self._n
        derivatives = np.empty((rows, width, columns))
        if self._bends:
            states = self._core.array("law_states", -1)
            states[-self._bends :] = 0.0 if slips is None else slips
        bad = self._c.core_sensitivity_roll(
            *(self._handle, q, q + 8 * self._n, rows, steps, h),
            *(tensions.ctypes.data, torques.ctypes.data, count, *addresses),
            *(readings.ctypes.data, derivatives.ctypes.data if columns else None),
        )
        return None if bad else Rolled(readings, derivatives)
