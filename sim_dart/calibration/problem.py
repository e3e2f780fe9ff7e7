"""Calibration by output error: roll-outs over short windows against what was read.

Unknown are theta, of the robot and its sensors, and of each window w where it begins, x_w = (q,
qd):

    min  sum_w |r_w(theta, x_w)|^2 + prior(theta),   r_w = (y_w - y(theta, x_w)) / noise

by Levenberg and Marquardt's method. With A = dr/dx and B = dr/dtheta of a window and A = Q R, the
starts are eliminated: what is left of a window is (I - Q Q') (r + B dtheta) (Golub & Pereyra 2003,
Inverse Problems 19). With theta held, windows find their starts one by one, by the same method.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from queue import SimpleQueue
from typing import NamedTuple, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import BoolArray, FloatArray, IntArray
from sim_dart.estimation.estimated_robot import cable_compliances
from sim_dart.muscles.friction import rubs

from .inertia import InertiaPrior, thickened
from .markers import SeenMarkers
from .parameters import Parameter, calibrated_robot
from .readings import Readings, Window, slips_along, smooth_start
from .sensitivity import Directions, Sensitivity, robot_numbers

LONGEST_STEP = 1e-3
"""Of roll-outs, in [s]: readings that are farther apart have several steps between them."""

_ROBOT = ("point", "cable_friction", "inertia", "damping", "friction", "armature")
_MOVING = (*_ROBOT, "gain", "tension_delay")
"""What changes the motion, and not its readings alone."""

_DIFFERENCE = 1e-4
_WITHOUT_EFFECT = 1e-12
"""Information in units of the prior below which a number changes no reading at all."""

_LEAST_FRICTION = 1e-3
"""Over its prior's deviation: what would rub cannot be seen at a joint that does not rub at all."""

_NEAR = 0.01
"""Numbers of inertias are linear, nearly, in changes below so much of their prior's deviation."""

_START_ITERATIONS = 40
_MOST_DAMPING = 1e6
_START_GAIN = 1e-2
"""Of a window's cost, below which its start is fitted: of thousands of readings' squares."""

_WORTH_THREADS = 16
"""Windows, from which on they are rolled side by side."""


_NONE = np.zeros(0, dtype=np.int32)

T = TypeVar("T")


class _Seen(NamedTuple):
    """A window, linear in the changes of theta and of its start, with the start eliminated."""

    start_change: FloatArray
    start_slope: FloatArray


@dataclass(frozen=True)
class Linearised:
    """All windows about theta and starts.

    Attributes:
        information: H of theta in units of the prior, starts eliminated, shape (P, P).
        gradient: Shape (P,).
        seen: Of each window, how its start follows theta.
    """

    information: FloatArray
    gradient: FloatArray
    seen: list[_Seen]


@dataclass(frozen=True)
class Settled:
    """All windows with theta held, each beginning where it fits best.

    Attributes:
        cost: Sum of squared residuals, without the prior.
        starts: Shape (2 n,) each.
        residuals: Of each window, in units of readings, shape (rows, n + m + 3 M).
    """

    cost: float
    starts: list[FloatArray]
    residuals: list[FloatArray]


class CalibrationProblem:
    """A robot, what is free of it, and how well it is read.

    Args:
        robot: As it is believed to be.
        parameters: The free ones; none to fit starts alone.
        noise: Of one reading, shape (n + m + 3 M,).
        inertia_sd: Of the prior of inertias; see `InertiaPrior`.
        longest_step: Of roll-outs, in [s].
        seen: Markers on it; none when None.
    """

    def __init__(
        self,
        robot: Robot,
        parameters: Sequence[Parameter],
        noise: FloatArray,
        inertia_sd: float,
        longest_step: float = LONGEST_STEP,
        seen: SeenMarkers | None = None,
    ) -> None:
        self._seen = seen
        self.robot, self.parameters = robot, tuple(parameters)
        self._n, self._m = len(robot.coordinates), len(robot.muscles)
        self._noise, self._longest = noise, longest_step
        self.sd = np.array([one.sd for one in parameters])
        self.low = np.array([(one.low - one.value) / one.sd for one in parameters])
        self.high = np.array([(one.high - one.value) / one.sd for one in parameters])
        self._rubs = np.array([one.kind == "friction" for one in parameters], dtype=bool)
        self.low[self._rubs] += _LEAST_FRICTION
        self._compliance = cable_compliances(robot)
        self._directions = np.zeros((len(self.parameters), robot_numbers(robot).size))
        self._priors = _inertia_priors(self.robot, self.parameters, inertia_sd)
        self._filled_at = np.zeros(len(self.parameters))
        self._fill_directions(self._filled_at, [one.kind in _ROBOT for one in self.parameters])
        self._bent = np.array([one.kind == "inertia" for one in self.parameters], dtype=bool)
        self._acts = np.arange(len(self.parameters), dtype=np.int32)
        self._rollers: SimpleQueue[Sensitivity] | None = None
        self._rolled_at = self._filled_at
        self._slips: WeakKeyDictionary[Readings, FloatArray] = WeakKeyDictionary()

    def skip_idle(self, information: FloatArray) -> None:
        """Roll no more along numbers that change no reading, such as those across a plane.

        Args:
            information: H by readings with all numbers, shape (P, P).
        """
        acts = np.flatnonzero(np.diag(information) > _WITHOUT_EFFECT)
        self._acts = acts.astype(np.int32)

    def robot_at(self, z: FloatArray) -> Robot:
        """The robot with theta = z sd."""
        return calibrated_robot(self.robot, self.parameters, z * self.sd)

    def without_traces(self, z: FloatArray) -> FloatArray:
        """Z, but no friction where it is at its least."""
        return np.where(self._rubs & (z <= self.low), z - _LEAST_FRICTION, z)

    def prior(self, z: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """The cost of theta by what was believed, half its gradient and half its Hessian."""
        cost, g, H = float(z @ z), z.copy(), np.eye(len(z))
        for at, prior in self._priors:
            s = self.sd[at]
            of_link, slope, bend = prior(z[at] * s)
            cost += of_link - float(z[at] @ z[at])
            g[at], H[np.ix_(at, at)] = slope * s, bend * s[:, None] * s
        return cost, g, H

    def settled(
        self, z: FloatArray, cut: Sequence[Window], starts: Sequence[FloatArray] | None = None
    ) -> Settled | None:
        """Where windows begin so that they fit best with theta held.

        Args:
            z: theta over its sd.
            cut: The windows.
            starts: Where to look from; what smooth motions say when left out.

        Returns:
            None where a window diverges.
        """
        begin = [smooth_start(window) for window in cut] if starts is None else starts

        def settled(roller: Sensitivity, window: Window, start: FloatArray) -> Settled | None:
            return self._settled(roller, window, start, z)

        found = list(self._every(settled, z, cut, begin))
        if any(one is None for one in found):
            return None
        every = [one for one in found if one is not None]
        return Settled(
            sum(one.cost for one in every),
            [one.starts[0] for one in every],
            [one.residuals[0] for one in every],
        )

    def _settled(
        self, roller: Sensitivity, window: Window, start: FloatArray, z: FloatArray
    ) -> Settled | None:
        """One window: Levenberg and Marquardt's method for its start alone."""
        here, damping = self._roll(roller, window, start, z, _NONE), 0.0
        if here is None:
            return None
        r, A = _whitened(*here, self._noise)
        cost, left = float(r @ r), here[0]
        for _ in range(_START_ITERATIONS):
            H = A.T @ A
            damped = H + damping * np.diag(np.diag(H))
            step = -np.linalg.pinv(damped, rcond=1e-12, hermitian=True) @ (A.T @ r)
            tried = self._roll(roller, window, start + step, z, None)
            new, _ = (None, None) if tried is None else _whitened(*tried, self._noise)
            after = np.inf if new is None else float(new @ new)
            if tried is None or after > cost:
                damping = max(10.0 * damping, 1e-2)
                if damping > _MOST_DAMPING:
                    break
                continue
            gain, start, cost, left, damping = (
                cost - after,
                start + step,
                after,
                tried[0],
                damping / 10.0,
            )
            if gain <= _START_GAIN:
                break
            here = self._roll(roller, window, start, z, _NONE)
            assert here is not None
            r, A = _whitened(*here, self._noise)
        return Settled(cost, [start], [left])

    def linearise(
        self, z: FloatArray, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Linearised | None:
        """Windows about a point; None where one diverges."""
        H, g, seen = np.zeros((len(z), len(z))), np.zeros(len(z)), []
        for one in self._linearised(z, cut, starts):
            if one is None:
                return None
            H += one.information
            g += one.gradient
            seen += one.seen
        return Linearised(H, g, seen)

    def informations(
        self, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[FloatArray] | None:
        """H of each window about what is believed, shape (P, P) each; None where one diverges."""
        found = []
        for one in self._linearised(np.zeros(len(self.parameters)), cut, starts):
            if one is None:
                return None
            found.append(one.information)
        return found

    def _linearised(
        self, z: FloatArray, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Iterator[Linearised | None]:
        """Each window with its start eliminated; None at the first that diverges."""
        if np.abs(z - self._filled_at)[self._bent].max(initial=0.0) > _NEAR:
            self._fill_directions(z, self._bent)
            self._filled_at = z

        def linearised(roller: Sensitivity, window: Window, start: FloatArray) -> Linearised | None:
            rolled = self._roll(roller, window, start, z, self._acts)
            return None if rolled is None else self._start_eliminated(*rolled)

        return self._every(linearised, z, cut, starts)

    def _every(
        self,
        what: Callable[[Sensitivity, Window, FloatArray], T | None],
        z: FloatArray,
        cut: Sequence[Window],
        starts: Sequence[FloatArray],
    ) -> Iterator[T | None]:
        """Of each window, side by side where they are many; None at the first that diverges."""
        rollers = self._rollers_at(z)

        def one_of(window: Window, start: FloatArray) -> T | None:
            roller = rollers.get()
            try:
                return what(roller, window, start)
            finally:
                rollers.put(roller)

        if len(cut) < _WORTH_THREADS:
            yield from map(one_of, cut, starts)
            return
        with ThreadPoolExecutor(rollers.qsize()) as pool:
            for one in pool.map(one_of, cut, starts):
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

    def _start_eliminated(self, left: FloatArray, slopes: FloatArray) -> Linearised:
        """One window, with its start eliminated."""
        r, J = _whitened(left, slopes, self._noise)
        A, B = J[:, -2 * self._n :], J[:, : -2 * self._n]
        Q, R = np.linalg.qr(A)
        inverse = np.linalg.pinv(R, rcond=1e-10)
        Qr, QB = Q.T @ r, Q.T @ B
        P, acts = len(self.parameters), self._acts
        H, g, follows = np.zeros((P, P)), np.zeros(P), np.zeros((2 * self._n, P))
        H[np.ix_(acts, acts)] = B.T @ B - QB.T @ QB
        g[acts] = B.T @ r - QB.T @ Qr
        follows[:, acts] = -inverse @ QB
        return Linearised(H, g, [_Seen(-inverse @ Qr, follows)])

    def _fill_directions(self, z: FloatArray, which: Sequence[bool] | BoolArray) -> None:
        """How the robot's numbers change with z: exact for what they are linear in."""
        for k in np.flatnonzero(which):
            step = np.zeros(len(z))
            step[k] = _DIFFERENCE if self.parameters[k].kind == "inertia" else 0.5
            ends = [robot_numbers(self.robot_at(z + way * step)) for way in (1.0, -1.0)]
            moved = np.where(ends[0] == ends[1], 0.0, ends[0])  # limits may be infinite
            still = np.where(ends[0] == ends[1], 0.0, ends[1])
            self._directions[k] = (moved - still) / (2.0 * step[k])

    def _moving(self, along: IntArray) -> IntArray:
        """Those along which the motion changes."""
        moving = [k for k in along if self.parameters[k].kind in _MOVING]
        return np.array(moving, dtype=np.int32)

    def _roll(
        self,
        roller: Sensitivity,
        window: Window,
        start: FloatArray,
        z: FloatArray,
        along: IntArray | None,
    ) -> tuple[FloatArray, FloatArray] | None:
        """What is left of a window, and its derivatives by z along some numbers, and the start.

        Along None there are no derivatives at all, and along no numbers those by the start.
        """
        rows, readings = len(window.measured), window.readings
        with_derivatives, along = along is not None, _NONE if along is None else along
        theta = z * self.sd
        delay = self._sum("tension_delay", theta)
        read, slope = readings.delayed_tensions(window.first, rows, delay)
        gain = np.ones(self._m)
        for one, change in zip(self.parameters, theta, strict=True):
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

    def _steps(self, readings: Readings) -> int:
        return max(1, int(np.ceil(readings.step / self._longest - 1e-9)))

    def _slips_at(self, window: Window) -> FloatArray | None:
        """How cables with friction rub where a window begins, as its recording has moved them."""
        if not rubs(self.robot):
            return None
        readings = window.readings
        if readings not in self._slips:
            steps = self._steps(readings)
            self._slips[readings] = slips_along(self.robot, readings.poses, steps)
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
        for one, change in zip(self.parameters, theta, strict=True):
            if one.kind == "marker":
                positions[one.item, one.part[0]] += change
        p, dp, R = seen.at(q, positions)
        moved = dp @ slopes
        for column, k in enumerate(along):
            one = self.parameters[k]
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
        for one, change in zip(self.parameters, theta, strict=True):
            if one.kind == "offset":
                lengths[:, one.item] += change
            if one.kind == "stiffness":
                stiff[:, one.item] = -tensions[:, one.item] / (one.value + change)
        for column, k in enumerate(along):
            one = self.parameters[k]
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
            one = self.parameters[k]
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
        """The value of a parameter that there is one of at most."""
        found = (t for one, t in zip(self.parameters, theta, strict=True) if one.kind == kind)
        return float(sum(found))


def _inertia_priors(
    robot: Robot, parameters: Sequence[Parameter], sd: float
) -> list[tuple[IntArray, InertiaPrior]]:
    """Of each link whose numbers are free, where they are among the parameters."""
    at: dict[int, list[int]] = {}
    for k, one in enumerate(parameters):
        if one.kind == "inertia":
            at.setdefault(one.item, []).append(k)
    return [
        (np.array(rows, dtype=np.int32), InertiaPrior(thickened(robot.links[link].inertia), sd))
        for link, rows in at.items()
    ]


def _whitened(
    left: FloatArray, slopes: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals and derivatives over the noise, without readings that there are not."""
    taken = ~np.isnan(left).ravel()
    weight = np.broadcast_to(1.0 / noise, left.shape).ravel()[taken]
    J = slopes.reshape(left.size, slopes.shape[2])[taken] * weight[:, None]
    return left.ravel()[taken] * weight, J
