"""Roll-outs with exact derivatives by the numbers of a robot, computed by the complex core."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, IntArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core, blob_reals, library
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.muscles.friction import bend_count


@cache
def _bound() -> Any:
    core = ctypes.CDLL(library()._name)  # releases the GIL, since windows take milliseconds
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
    """Directions of derivatives of a roll-out, in addition to the start state.

    Attributes:
        robot: Derivatives of the robot's numbers, shape (directions, numbers).
        changes: Derivatives of tensions, shape (k, rows, m).
        commanded: Index in `changes` of each direction, or -1, shape (directions,).
    """

    robot: FloatArray
    changes: FloatArray
    commanded: IntArray


class Rolled(NamedTuple):
    """Result of a roll-out.

    Attributes:
        readings: Simulated q and path lengths, shape (rows, n + m).
        derivatives: Derivatives by the directions, then by q and qd at the start, shape
            (rows, n + m, directions + 2 n); without columns if no derivatives were computed.
    """

    readings: FloatArray
    derivatives: FloatArray


def robot_numbers(robot: Robot) -> FloatArray:
    """Return the real numbers of the robot's blob for roll-outs, shape (numbers,)."""
    return blob_reals(compile_blob(estimated_robot(robot)))


class Sensitivity:
    """Simulation of a robot with measured tensions, and its derivatives.

    Args:
        robot: The robot. Its driven muscles are treated as ideal cables.
    """

    def __init__(self, robot: Robot) -> None:
        self._core = Core(compile_blob(estimated_robot(robot)))
        self._c = _bound()
        size = self._c.core_sensitivity_size(self._core.handle)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._bends = sum(map(bend_count, robot.muscles))
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
        """Simulate the motion over a window.

        Args:
            start: q and qd at the first measurement, shape (2 n,).
            tensions: Tensions after each measurement, shape (rows, m), in [N].
            torques: Torques of joint motors, shape (rows, n), in [N·m] or [N].
            h: Step, in [s].
            steps: Steps between two measurements.
            along: Directions of derivatives, or None for no derivatives, which is much faster.
            slips: Slip states at the first measurement, shape (bends,) (default: 0).

        Returns:
            The roll-out, or None if the state diverged.
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
