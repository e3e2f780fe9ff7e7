"""Calibration by output error: roll-outs over short windows against what was read.

Unknown are theta, of the robot and its sensors, and of each window w where it begins, x_w = (q,
qd):

    min  sum_w |r_w(theta, x_w)|^2 + prior(theta),   r_w = (y_w - y(theta, x_w)) / noise

by Levenberg and Marquardt's method. Starts are eliminated window by window; with theta held,
windows find their starts one by one, by the same method.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, IntArray

from .inertia import InertiaPrior, thickened
from .markers import SeenMarkers
from .parameters import Parameter
from .readings import Window, smooth_start
from .roll_outs import NONE, RollOuts
from .sensitivity import Sensitivity
from .starts import Eliminated, Left, Settled, eliminate, settle, whitened, without_start

MAX_STEP = 1e-3
"""Of roll-outs, in [s]: readings that are farther apart have several steps between them."""

_WITHOUT_EFFECT = 1e-12
"""Information in units of the prior below which a number changes no reading at all."""

_MIN_FRICTION = 1e-3
"""Over its prior's deviation: what would rub cannot be seen at a joint that does not rub at all."""


@dataclass(frozen=True)
class Linearised:
    """All windows about theta and starts.

    Attributes:
        information: H of theta in units of the prior, starts eliminated, shape (P, P).
        gradient: Shape (P,).
        start_changes: Of each window's start, with theta held, shape (2 n,) each.
        start_slopes: How each follows theta, shape (2 n, P) each.
        start_solvers: See `Eliminated`.
    """

    information: FloatArray
    gradient: FloatArray
    start_changes: list[FloatArray]
    start_slopes: list[FloatArray]
    start_solvers: list[FloatArray]


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
        longest_step: float = MAX_STEP,
        seen: SeenMarkers | None = None,
    ) -> None:
        self.robot, self.parameters = robot, tuple(parameters)
        self._noise = noise
        self.sd = np.array([one.sd for one in parameters])
        self.low = np.array([(one.low - one.value) / one.sd for one in parameters])
        self.high = np.array([(one.high - one.value) / one.sd for one in parameters])
        self._is_friction = np.array([one.kind == "friction" for one in parameters], dtype=bool)
        self.low[self._is_friction] += _MIN_FRICTION
        self._priors = _inertia_priors(self.robot, self.parameters, inertia_sd)
        self._rolls = RollOuts(robot, parameters, longest_step, seen)
        self._acts = np.arange(len(self.parameters), dtype=np.int32)

    def skip_idle(self, information: FloatArray) -> None:
        """Roll no more along numbers that change no reading, such as those across a plane.

        Args:
            information: H by readings with all numbers, shape (P, P).
        """
        acts = np.flatnonzero(np.diag(information) > _WITHOUT_EFFECT)
        self._acts = acts.astype(np.int32)

    def robot_at(self, z: FloatArray) -> Robot:
        """Return the robot with theta = z sd."""
        return self._rolls.robot_at(z)

    def without_traces(self, z: FloatArray) -> FloatArray:
        """Z, but no friction if it is at its least."""
        return np.where(self._is_friction & (z <= self.low), z - _MIN_FRICTION, z)

    def prior(self, z: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return the cost of theta by what was believed, half its gradient and half its Hessian."""
        cost, g, H = float(z @ z), z.copy(), np.eye(len(z))
        for at, prior in self._priors:
            s = self.sd[at]
            of_link, slope, bend = prior(z[at] * s)
            cost += of_link - float(z[at] @ z[at])
            g[at], H[np.ix_(at, at)] = slope * s, bend * s[:, None] * s
        return cost, g, H

    def settled(
        self,
        z: FloatArray,
        cut: Sequence[Window],
        starts: Sequence[FloatArray] | None = None,
        solvers: Sequence[FloatArray] | None = None,
    ) -> Settled | None:
        """Where windows begin so that they fit best with theta held.

        Args:
            z: theta over its sd.
            cut: The windows.
            starts: Where to look from; what smooth motions say if omitted.
            solvers: Of a linearisation near z.

        Returns:
            None if a window diverges.
        """
        begin = [smooth_start(window) for window in cut] if starts is None else starts
        near = [None] * len(cut) if solvers is None else solvers

        def settled(
            roller: Sensitivity, window: Window, at: tuple[FloatArray, FloatArray | None]
        ) -> Settled | None:
            def roll(start: FloatArray, with_derivatives: bool) -> Left | None:
                along = NONE if with_derivatives else None
                return self._rolls.left(roller, window, start, z, along)

            return settle(roll, at[0], self._noise, at[1])

        every, places = [], list(zip(begin, near, strict=True))
        for one in self._rolls.every(settled, z, cut, places):
            if one is None:
                return None
            every.append(one)
        return Settled(
            sum(one.cost for one in every),
            [one.starts[0] for one in every],
            [one.residuals[0] for one in every],
        )

    def linearise(
        self, z: FloatArray, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Linearised | None:
        """Windows about a point; None if one diverges."""
        P, acts = len(z), self._acts
        H, g = np.zeros((len(acts), len(acts))), np.zeros(len(acts))
        changes, slopes, solvers = [], [], []
        for one in self._eliminated(z, cut, starts):
            if one is None:
                return None
            H += one.information
            g += one.gradient
            changes.append(one.start_change)
            slopes.append(_among(one.start_slope, acts, P))
            solvers.append(one.start_solver)
        H = _among(_among(H, acts, P).T, acts, P)
        return Linearised(H, _among(g[None], acts, P)[0], changes, slopes, solvers)

    def bent(
        self,
        z: FloatArray,
        cut: Sequence[Window],
        starts: Sequence[FloatArray],
        changes: FloatArray,
    ) -> tuple[FloatArray, FloatArray] | None:
        """By how much roll-outs along changes are not straight.

        Args:
            z: theta over its sd, shape (P,).
            cut: The windows.
            starts: Where they begin, so that they fit best.
            changes: Of z, shape (S, P).

        Returns:
            H at z, shape (P, P), and J'(r(z + c) - 2 r(z) + r(z - c)) of each change c, shape
            (S, P), with the residuals r and their derivatives J, starts eliminated. None if a
            window diverges.
        """
        P, acts, size = len(z), self._acts, 2 * len(self.robot.coordinates)
        self._rolls.differentiate_at(z)

        def straight(
            roller: Sensitivity, window: Window, start: FloatArray
        ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
            left = self._rolls.left(roller, window, start, z, acts)
            if left is None:
                return None
            return whitened(left[0], self._noise), *without_start(left, size, self._noise)

        about = []
        for one in self._rolls.every(straight, z, cut, starts):
            if one is None:
                return None
            about.append(one)
        H = np.zeros((len(acts), len(acts)))
        for _, B, _ in about:
            H += B.T @ B
        found = np.zeros((len(changes), P))
        for change, row in zip(changes, found, strict=True):
            for way in (1.0, -1.0):
                there = z + way * change

                def plain(
                    roller: Sensitivity,
                    window: Window,
                    start: FloatArray,
                    there: FloatArray = there,
                ) -> FloatArray | None:
                    left = self._rolls.left(roller, window, start, there, None)
                    return None if left is None else whitened(left[0], self._noise)

                moved = [
                    start + way * slope @ change[acts]
                    for start, (_, _, slope) in zip(starts, about, strict=True)
                ]
                rolled = self._rolls.every(plain, there, cut, moved)
                for r, (r0, B, _) in zip(rolled, about, strict=True):
                    if r is None:
                        return None
                    row[acts] += B.T @ (r - r0)
        return _among(_among(H, acts, P).T, acts, P), found

    def informations(
        self, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[FloatArray] | None:
        """H of each window about what is believed, shape (P, P) each; None if one diverges."""
        found, P, acts = [], len(self.parameters), self._acts
        for one in self._eliminated(np.zeros(P), cut, starts):
            if one is None:
                return None
            found.append(_among(_among(one.information, acts, P).T, acts, P))
        return found

    def _eliminated(
        self, z: FloatArray, cut: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Iterator[Eliminated | None]:
        """Each window with its start eliminated; None at the first that diverges."""
        self._rolls.differentiate_at(z)
        size = 2 * len(self.robot.coordinates)

        def eliminated(roller: Sensitivity, window: Window, start: FloatArray) -> Eliminated | None:
            left = self._rolls.left(roller, window, start, z, self._acts)
            return None if left is None else eliminate(left, size, self._noise)

        return self._rolls.every(eliminated, z, cut, starts)


def _among(columns: FloatArray, acts: IntArray, count: int) -> FloatArray:
    """Return columns of the numbers that act among those of all, zeros for the others."""
    whole = np.zeros((len(columns), count))
    whole[:, acts] = columns
    return whole


def _inertia_priors(
    robot: Robot, parameters: Sequence[Parameter], sd: float
) -> list[tuple[IntArray, InertiaPrior]]:
    """Of each link whose numbers are free, if they are among the parameters."""
    at: dict[int, list[int]] = {}
    for k, one in enumerate(parameters):
        if one.kind == "inertia":
            at.setdefault(one.item, []).append(k)
    return [
        (np.array(rows, dtype=np.int32), InertiaPrior(thickened(robot.links[link].inertia), sd))
        for link, rows in at.items()
    ]
