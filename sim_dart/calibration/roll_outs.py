"""Roll-outs of windows: residuals of measurements and their derivatives by parameters."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from queue import SimpleQueue
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import BoolArray, FloatArray, IntArray
from sim_dart.estimation.estimated_robot import cable_compliances
from sim_dart.muscles.friction import has_cable_friction

from .markers import MarkerKinematics
from .parameters import Parameter, calibrated_robot
from .recordings import Recording, Window, slip_states_along
from .sensitivity import Directions, Sensitivity, robot_numbers
from .window_starts import Residuals

_ROBOT = ("point", "cable_friction", "inertia", "damping", "friction", "armature")
_MOVING = (*_ROBOT, "gain", "tension_delay")
"""Kinds of parameters that change the motion, not only its measurements."""

_DIFFERENCE = 1e-4
_NEAR = 0.01
"""Changes of inertias below this fraction of their prior sd are treated as linear."""

_MIN_PARALLEL_WINDOWS = 16
"""Number of windows from which roll-outs are computed in parallel."""

NONE = np.zeros(0, dtype=np.int32)

S = TypeVar("S")
T = TypeVar("T")


class RollOuts:
    """Roll-outs of a robot with the parameters theta = z sd.

    The arguments are those of `CalibrationProblem`.
    """

    def __init__(
        self,
        robot: Robot,
        parameters: Sequence[Parameter],
        max_step: float,
        markers: MarkerKinematics | None,
    ) -> None:
        self._robot, self._parameters = robot, tuple(parameters)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._max_step, self._markers = max_step, markers
        self._sd = np.array([one.sd for one in parameters])
        self._compliance = cable_compliances(robot)
        self._directions = np.zeros((len(self._parameters), robot_numbers(robot).size))
        self._filled_at = np.zeros(len(self._parameters))
        self._fill_directions(self._filled_at, [one.kind in _ROBOT for one in self._parameters])
        self._is_nonlinear = np.array(
            [one.kind == "inertia" for one in self._parameters], dtype=bool
        )
        self._rollers: SimpleQueue[Sensitivity] | None = None
        self._rolled_at = self._filled_at
        self._slips: WeakKeyDictionary[Recording, FloatArray] = WeakKeyDictionary()

    def robot_at(self, z: FloatArray) -> Robot:
        """Return the robot with the parameters theta = z sd."""
        return calibrated_robot(self._robot, self._parameters, z * self._sd)

    def differentiate_at(self, z: FloatArray) -> None:
        """Evaluate derivatives by inertias, which are not linear in z, at z."""
        if np.abs(z - self._filled_at)[self._is_nonlinear].max(initial=0.0) > _NEAR:
            self._fill_directions(z, self._is_nonlinear)
            self._filled_at = z

    def map_windows(
        self,
        function: Callable[[Sensitivity, Window, S], T | None],
        z: FloatArray,
        windows: Sequence[Window],
        items: Sequence[S],
    ) -> list[T] | None:
        """Apply a function to windows, in parallel if useful; None if a window diverges."""
        rollers = self._rollers_at(z)

        def run(window: Window, item: S) -> T | None:
            roller = rollers.get()
            try:
                return function(roller, window, item)
            finally:
                rollers.put(roller)

        results: list[T] = []
        with ThreadPoolExecutor(rollers.qsize()) as pool:
            mapped = map if len(windows) < _MIN_PARALLEL_WINDOWS else pool.map
            for one in mapped(run, windows, items):
                if one is None:
                    pool.shutdown(cancel_futures=True)
                    return None
                results.append(one)
        return results

    def _rollers_at(self, z: FloatArray) -> SimpleQueue[Sensitivity]:
        """Create the robot with theta = z sd for each thread. A core supports only one thread."""
        if self._rollers is None or not np.array_equal(z, self._rolled_at):
            self._rollers, self._rolled_at, robot = SimpleQueue(), z.copy(), self.robot_at(z)
            for _ in range(os.cpu_count() or 1):
                self._rollers.put(Sensitivity(robot))
        return self._rollers

    def residuals(
        self,
        roller: Sensitivity,
        window: Window,
        start: FloatArray,
        z: FloatArray,
        along: IntArray | None,
    ) -> Residuals | None:
        """Compute the residuals of a window, and their derivatives by z and the start state.

        Args:
            roller: The roller that `map_windows` provides for the window.
            start: Start state, shape (2 n,).
            z: Parameters theta over their sd, shape (P,).
            along: Indices of the parameters for derivatives, in order. If empty, only derivatives
                by the start state are computed. If None, no derivatives are computed.

        Returns:
            Residuals and derivatives, or None if the roll-out diverges.
        """
        rows, recording = len(window.measured), window.recording
        with_derivatives, along = along is not None, NONE if along is None else along
        theta = z * self._sd
        delay = self._sum("tension_delay", theta)
        read, slope = recording.delayed_tensions(window.first, rows, delay)
        gain = np.ones(self._m)
        for one, change in zip(self._parameters, theta, strict=True):
            if one.kind == "gain":
                gain[one.item] += change
        moving = self._moving(along)
        commanded, changes = self._command_changes(read, slope * gain, moving)
        steps = self._steps(recording)
        torques = recording.torques[window.first : window.first + rows]
        h = recording.step / steps
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
        self._add_sensors(y[:, n:], slopes[:, n:], recording.step, tensions, theta, along)
        if self._markers is not None:
            positions, moved = self._marker_positions(y[:, :n], slopes[:, :n], theta, along)
            y, slopes = np.hstack([y, positions]), np.hstack([slopes, moved])
        return window.measured - y, -slopes

    def _fill_directions(self, z: FloatArray, which: Sequence[bool] | BoolArray) -> None:
        """Compute derivatives of the robot's numbers by z. They are exact for linear parameters."""
        for k in np.flatnonzero(which):
            step = np.zeros(len(z))
            step[k] = _DIFFERENCE if self._parameters[k].kind == "inertia" else 0.5
            ends = [robot_numbers(self.robot_at(z + way * step)) for way in (1.0, -1.0)]
            moved = np.where(ends[0] == ends[1], 0.0, ends[0])  # for limits that are infinite
            still = np.where(ends[0] == ends[1], 0.0, ends[1])
            self._directions[k] = (moved - still) / (2.0 * step[k])

    def _moving(self, along: IntArray) -> IntArray:
        """Return the parameters that change the motion."""
        moving = [k for k in along if self._parameters[k].kind in _MOVING]
        return np.array(moving, dtype=np.int32)

    def _steps(self, recording: Recording) -> int:
        return max(1, int(np.ceil(recording.step / self._max_step - 1e-9)))

    def _slips_at(self, window: Window) -> FloatArray | None:
        """Return the slip states at the start of a window, computed from the recorded motion."""
        if not has_cable_friction(self._robot):
            return None
        recording = window.recording
        if recording not in self._slips:
            steps = self._steps(recording)
            self._slips[recording] = slip_states_along(self._robot, recording.poses, steps)
        slips: FloatArray = self._slips[recording][window.first]
        return slips

    def _marker_positions(
        self,
        q: FloatArray,
        slopes: FloatArray,
        theta: FloatArray,
        along: IntArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return the marker positions at the poses of a window, and their derivatives."""
        assert self._markers is not None
        positions = self._markers.positions.copy()
        for one, change in zip(self._parameters, theta, strict=True):
            if one.kind == "marker":
                positions[one.item, one.part[0]] += change
        p, dp, R = self._markers.at(q, positions)
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
        """Convert path lengths to lengths at the motors, l - f / k + b, including the delay."""
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
        """Return the derivatives of tensions by parameters of their sensors."""
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
        """Return the value of a parameter kind that exists at most once, or 0."""
        values = (t for one, t in zip(self._parameters, theta, strict=True) if one.kind == kind)
        return float(sum(values))
