"""Roll-outs of windows by a robot's free numbers: what is left of readings, with derivatives."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import BoolArray, FloatArray, IntArray
from sim_dart.estimation.estimated_robot import cable_compliances
from sim_dart.muscles.friction import has_cable_friction

from .markers import SeenMarkers
from .parameters import Parameter, calibrated_robot
from .readings import Readings, Window, slips_along
from .sensitivity import Directions, Sensitivity, robot_numbers
from .starts import Left

_ROBOT = ("point", "cable_friction", "inertia", "damping", "friction", "armature")
_MOVING = (*_ROBOT, "gain", "tension_delay")
"""What changes the motion, and not its readings alone."""

_DIFFERENCE = 1e-4
_NEAR = 0.01
"""Numbers of inertias are linear, nearly, in changes below so much of their prior's deviation."""

_WORTH_THREADS = 16
"""Windows, from which on they are rolled side by side."""

NONE = np.zeros(0, dtype=np.int32)

S = TypeVar("S")
T = TypeVar("T")


class RollOuts:
    """A robot that rolls through windows, with theta = z sd.

    Args:
        robot: As it is believed to be.
        parameters: The free ones; none to fit starts alone.
        longest_step: Of roll-outs, in [s].
        seen: Markers on it; none when None.
    """

    def __init__(
        self,
        robot: Robot,
        parameters: Sequence[Parameter],
        longest_step: float,
        seen: SeenMarkers | None,
    ) -> None:
        self._robot, self._parameters = robot, tuple(parameters)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._longest, self._seen = longest_step, seen
        self._sd = np.array([one.sd for one in parameters])
        self._compliance = cable_compliances(robot)
        self._directions = np.zeros((len(self._parameters), robot_numbers(robot).size))
        self._filled_at = np.zeros(len(self._parameters))
        self._fill_directions(self._filled_at, [one.kind in _ROBOT for one in self._parameters])
        self._bent = np.array([one.kind == "inertia" for one in self._parameters], dtype=bool)
        self._rollers: SimpleQueue[Sensitivity] | None = None
        self._rolled_at = self._filled_at
        self._slips: WeakKeyDictionary[Readings, FloatArray] = WeakKeyDictionary()

    def robot_at(self, z: FloatArray) -> Robot:
        """Return the robot with theta = z sd."""
        return calibrated_robot(self._robot, self._parameters, z * self._sd)

    def differentiate_at(self, z: FloatArray) -> None:
        """Have derivatives by the numbers of inertias, which are not linear in z, those at z."""
        if np.abs(z - self._filled_at)[self._bent].max(initial=0.0) > _NEAR:
            self._fill_directions(z, self._bent)
            self._filled_at = z

    def every(
        self,
        what: Callable[[Sensitivity, Window, S], T | None],
        z: FloatArray,
        cut: Sequence[Window],
        of_each: Sequence[S],
    ) -> Iterator[T | None]:
        """Of each window, side by side if they are many; None at the first that diverges."""
        rollers = self._rollers_at(z)

        def one_of(window: Window, mine: S) -> T | None:
            roller = rollers.get()
            try:
                return what(roller, window, mine)
            finally:
                rollers.put(roller)

        if len(cut) < _WORTH_THREADS:
            yield from map(one_of, cut, of_each)
            return
        with ThreadPoolExecutor(rollers.qsize()) as pool:
            for one in pool.map(one_of, cut, of_each):
                yield one
                if one is None:
                    pool.shutdown(cancel_futures=True)
                    return

    def _rollers_at(self, z: FloatArray) -> SimpleQueue[Sensitivity]:
        """The robot with theta = z sd, one for each thread, as a core serves one at a time."""
        if self._rollers is None or not np.array_equal(z, self._rolled_at):
            self._rollers, self._rolled_at, robot = SimpleQueue(), z.copy(), self.robot_at(z)
            for _ in range(os.cpu_count() or 1):
                self._rollers.put(Sensitivity(robot))
        return self._rollers

    def left(
        self,
        roller: Sensitivity,
        window: Window,
        start: FloatArray,
        z: FloatArray,
        along: IntArray | None,
    ) -> Left | None:
        """Remainder of a window, and its derivatives by z along some numbers, and the start.

        Along None there are no derivatives at all, and along no numbers those by the start.

        Args:
            roller: That `every` gave for the window.
            window: The window.
            start: Where it begins, shape (2 n,).
            z: theta over its sd, shape (P,).
            along: Indices of the numbers, in their order.

        Returns:
            None if it diverges.
        """
        rows, readings = len(window.measured), window.readings
        with_derivatives, along = along is not None, NONE if along is None else along
        theta = z * self._sd
        delay = self._sum("tension_delay", theta)
        read, slope = readings.delayed_tensions(window.first, rows, delay)
        gain = np.ones(self._m)
        for one, change in zip(self._parameters, theta, strict=True):
            if one.kind == "gain":
                gain[one.item] += change
        moving = self._moving(along)
        commanded, changes = self._command_changes(read, slope * gain, moving)
        steps = self._steps(readings)
        torques = readings.torques[window.first : window.first + rows]
        h = readings.step / steps
        tensions = read * gain
        directions = Directions(self._directions[moving], changes, commanded)
        of = directions if with_derivatives else None
        rolled = roller.roll(start, tensions, torques, h, steps, of, self._slips_at(window))
        if rolled is None:
            return None
        y, n = rolled.readings.copy(), self._n
        slopes = np.zeros((*y.shape, len(along) + (2 * n if with_derivatives else 0)))
        slopes[:, :, np.searchsorted(along, moving)] = rolled.derivatives[:, :, : len(moving)]
        slopes[:, :, len(along) :] = rolled.derivatives[:, :, len(moving) :]
        self._add_sensors(y[:, n:], slopes[:, n:], readings.step, tensions, theta, along)
        if self._seen is not None:
            markers, seen = self._markers(self._seen, y[:, :n], slopes[:, :n], theta, along)
            y, slopes = np.hstack([y, markers]), np.hstack([slopes, seen])
        return window.measured - y, -slopes

    def _fill_directions(self, z: FloatArray, which: Sequence[bool] | BoolArray) -> None:
        """How the robot's numbers change with z: exact for what they are linear in."""
        for k in np.flatnonzero(which):
            step = np.zeros(len(z))
            step[k] = _DIFFERENCE if self._parameters[k].kind == "inertia" else 0.5
            ends = [robot_numbers(self.robot_at(z + way * step)) for way in (1.0, -1.0)]
            moved = np.where(ends[0] == ends[1], 0.0, ends[0])  # limits may be infinite
            still = np.where(ends[0] == ends[1], 0.0, ends[1])
            self._directions[k] = (moved - still) / (2.0 * step[k])

    def _moving(self, along: IntArray) -> IntArray:
        """Those along which the motion changes."""
        moving = [k for k in along if self._parameters[k].kind in _MOVING]
        return np.array(moving, dtype=np.int32)

    def _steps(self, readings: Readings) -> int:
        return max(1, int(np.ceil(readings.step / self._longest - 1e-9)))

    def _slips_at(self, window: Window) -> FloatArray | None:
        """How cables with friction rub where a window begins, as its recording has moved them."""
        if not has_cable_friction(self._robot):
            return None
        readings = window.readings
        if readings not in self._slips:
            steps = self._steps(readings)
            self._slips[readings] = slips_along(self._robot, readings.poses, steps)
        slips: FloatArray = self._slips[readings][window.first]
        return slips

    def _markers(
        self,
        seen: SeenMarkers,
        q: FloatArray,
        slopes: FloatArray,
        theta: FloatArray,
        along: IntArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Where markers are at the poses of a window, and their derivatives."""
        positions = seen.positions.copy()
        for one, change in zip(self._parameters, theta, strict=True):
            if one.kind == "marker":
                positions[one.item, one.part[0]] += change
        p, dp, R = seen.at(q, positions)
        moved = dp @ slopes
        for column, k in enumerate(along):
            one = self._parameters[k]
            if one.kind == "marker":
                row = slice(3 * one.item, 3 * one.item + 3)
                moved[:, row, column] += one.sd * R[:, one.item, :, one.part[0]]
        return p, moved

    def _add_sensors(
        self,
        lengths: FloatArray,
        slopes: FloatArray,
        step: float,
        tensions: FloatArray,
        theta: FloatArray,
        along: IntArray,
    ) -> None:
        """Make path lengths those at the motors: l - f / k + b, read late."""
        stiff: FloatArray = -tensions * self._compliance
        rates = np.gradient(lengths, step, axis=0)
        late = self._sum("length_delay", theta)
        lengths -= rates * late
        if late:
            slopes -= late * np.gradient(slopes, step, axis=0)
        for one, change in zip(self._parameters, theta, strict=True):
            if one.kind == "offset":
                lengths[:, one.item] += change
            if one.kind == "stiffness":
                stiff[:, one.item] = -tensions[:, one.item] / (one.value + change)
        for column, k in enumerate(along):
            one = self._parameters[k]
            if one.kind == "offset":
                slopes[:, one.item, column] += one.sd
            elif one.kind == "stiffness":
                stiffness = one.value + theta[k]
                slopes[:, one.item, column] += tensions[:, one.item] / stiffness**2 * one.sd
            elif one.kind == "length_delay":
                slopes[:, :, column] -= rates * one.sd
        lengths += stiff

    def _command_changes(
        self, read: FloatArray, slope: FloatArray, along: IntArray
    ) -> tuple[IntArray, FloatArray]:
        """How tensions change along the parameters of their sensors."""
        commanded = np.full(len(along), -1, dtype=np.int32)
        changes = []
        for column, k in enumerate(along):
            one = self._parameters[k]
            if one.kind == "tension_delay":
                changes.append(one.sd * slope)
            elif one.kind == "gain":
                change = np.zeros_like(read)
                change[:, one.item] = one.sd * read[:, one.item]
                changes.append(change)
            else:
                continue
            commanded[column] = len(changes) - 1
        return commanded, np.array(changes).reshape(-1, *read.shape)

    def _sum(self, kind: str, theta: FloatArray) -> float:
        """Return the value of a parameter that there is one of at most."""
        found = (t for one, t in zip(self._parameters, theta, strict=True) if one.kind == kind)
        return float(sum(found))
