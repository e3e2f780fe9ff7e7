"""Output-error calibration problem: roll-outs over short windows are fitted to measurements.

The unknowns are the parameters theta of the robot and its sensors, and the start state
x_w = (q, qd) of each window w:

    min  sum_w |r_w(theta, x_w)|^2 + prior(theta),   r_w = (y_w - y(theta, x_w)) / noise

The Levenberg-Marquardt method solves this problem. Start states are eliminated in each window. For
fixed theta, the start state of each window is fitted separately by the same method.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, IntArray

from .inertia import InertiaPrior, thicken
from .markers import MarkerKinematics
from .parameters import Parameter
from .recordings import Window, smoothed_start
from .roll_outs import NONE, RollOuts
from .sensitivity import Sensitivity
from .window_starts import (
    FittedWindows,
    ReducedWindow,
    Residuals,
    eliminate,
    fit_start,
    normalise,
    project_out_start,
)

MAX_STEP = 1e-3
"""Largest step of roll-outs, in [s]. Larger sampling periods are divided into several steps."""

_WITHOUT_EFFECT = 1e-12
"""Information in units of the prior below which a parameter has no effect."""

_MIN_FRICTION = 1e-3
"""Smallest friction over its prior sd. At zero friction its derivative would vanish."""


@dataclass(frozen=True)
class Linearisation:
    """Linearisation of all windows in theta and start states.

    Attributes:
        information: Information matrix H of theta in units of the prior, with eliminated start
            states, shape (P, P).
        gradient: Gradient, shape (P,).
        start_changes: Changes of the start states for fixed theta, shape (2 n,) each.
        start_slopes: Derivatives of the start states by theta, shape (2 n, P) each.
        start_solvers: See `ReducedWindow`.
    """

    information: FloatArray
    gradient: FloatArray
    start_changes: list[FloatArray]
    start_slopes: list[FloatArray]
    start_solvers: list[FloatArray]


class CalibrationProblem:
    """Calibration problem of a robot.

    Args:
        robot: The original robot.
        parameters: The free parameters; empty to fit only start states.
        noise: Standard deviation of one measurement, shape (n + m + 3 M,).
        inertia_sd: Standard deviation of the prior of inertias; see `InertiaPrior`.
        max_step: Largest step of roll-outs, in [s].
        seen: Motion-capture markers, or None.
    """

    def __init__(
        self,
        robot: Robot,
        parameters: Sequence[Parameter],
        noise: FloatArray,
        inertia_sd: float,
        max_step: float = MAX_STEP,
        seen: MarkerKinematics | None = None,
    ) -> None:
        self.robot, self.parameters = robot, tuple(parameters)
        self._noise = noise
        self.sd = np.array([one.sd for one in parameters])
        self.low = np.array([(one.low - one.value) / one.sd for one in parameters])
        self.high = np.array([(one.high - one.value) / one.sd for one in parameters])
        self._is_friction = np.array([one.kind == "friction" for one in parameters], dtype=bool)
        self.low[self._is_friction] += _MIN_FRICTION
        self._priors = _inertia_priors(self.robot, self.parameters, inertia_sd)
        self._rolls = RollOuts(robot, parameters, max_step, seen)
        self._acts = np.arange(len(self.parameters), dtype=np.int32)

    def exclude_ineffective(self, information: FloatArray) -> None:
        """Exclude parameters without effect from later roll-outs.

        An example are out-of-plane positions of a planar robot.

        Args:
            information: Information matrix H of the measurements, shape (P, P).
        """
        acts = np.flatnonzero(np.diag(information) > _WITHOUT_EFFECT)
        self._acts = acts.astype(np.int32)

    def robot_at(self, z: FloatArray) -> Robot:
        """Return the robot with the parameters theta = z sd."""
        return self._rolls.robot_at(z)

    def with_zero_friction(self, z: FloatArray) -> FloatArray:
        """Return z with friction at its lower bound replaced by zero friction."""
        return np.where(self._is_friction & (z <= self.low), z - _MIN_FRICTION, z)

    def prior(self, z: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return the prior cost of theta, half its gradient and half its Hessian."""
        cost, g, H = float(z @ z), z.copy(), np.eye(len(z))
        for at, prior in self._priors:
            s = self.sd[at]
            of_link, slope, bend = prior(z[at] * s)
            cost += of_link - float(z[at] @ z[at])
            g[at], H[np.ix_(at, at)] = slope * s, bend * s[:, None] * s
        return cost, g, H

    def fit_windows(
        self,
        z: FloatArray,
        windows: Sequence[Window],
        starts: Sequence[FloatArray] | None = None,
        solvers: Sequence[FloatArray] | None = None,
    ) -> FittedWindows | None:
        """Fit the start states of windows for fixed theta.

        Args:
            z: Parameters theta over their sd, shape (P,).
            starts: Initial start states (default: from smoothed measurements).
            solvers: Solvers of a linearisation near z.

        Returns:
            The fitted windows, or None if a window diverges.
        """
        begin = [smoothed_start(window) for window in windows] if starts is None else starts
        near = [None] * len(windows) if solvers is None else solvers

        def fit_window(
            roller: Sensitivity, window: Window, at: tuple[FloatArray, FloatArray | None]
        ) -> FittedWindows | None:
            def roll(start: FloatArray, with_derivatives: bool) -> Residuals | None:
                along = NONE if with_derivatives else None
                return self._rolls.residuals(roller, window, start, z, along)

            return fit_start(roll, at[0], self._noise, at[1])

        fitted, places = [], list(zip(begin, near, strict=True))
        for one in self._rolls.map_windows(fit_window, z, windows, places):
            if one is None:
                return None
            fitted.append(one)
        return FittedWindows(
            sum(one.cost for one in fitted),
            [one.starts[0] for one in fitted],
            [one.residuals[0] for one in fitted],
        )

    def linearise(
        self, z: FloatArray, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Linearisation | None:
        """Return the linearisation of windows at z, or None if a window diverges."""
        P, acts = len(z), self._acts
        H, g = np.zeros((len(acts), len(acts))), np.zeros(len(acts))
        changes, slopes, solvers = [], [], []
        for one in self._reduced_windows(z, windows, starts):
            if one is None:
                return None
            H += one.information
            g += one.gradient
            changes.append(one.start_change)
            slopes.append(_scatter(one.start_slope, acts, P))
            solvers.append(one.start_solver)
        H = _scatter(_scatter(H, acts, P).T, acts, P)
        return Linearisation(H, _scatter(g[None], acts, P)[0], changes, slopes, solvers)

    def second_order_terms(
        self,
        z: FloatArray,
        windows: Sequence[Window],
        starts: Sequence[FloatArray],
        changes: FloatArray,
    ) -> tuple[FloatArray, FloatArray] | None:
        """Compute second-order terms of roll-outs along changes of the parameters.

        Args:
            z: Parameters theta over their sd, shape (P,).
            starts: Fitted start states.
            changes: Changes of z, shape (S, P).

        Returns:
            H at z, shape (P, P), and J'(r(z + c) - 2 r(z) + r(z - c)) of each change c, shape
            (S, P), with residuals r and their derivatives J after elimination of start states.
            None if a window diverges.
        """
        P, acts, size = len(z), self._acts, 2 * len(self.robot.coordinates)
        self._rolls.differentiate_at(z)

        def linearise_window(
            roller: Sensitivity, window: Window, start: FloatArray
        ) -> tuple[FloatArray, FloatArray, FloatArray] | None:
            residuals = self._rolls.residuals(roller, window, start, z, acts)
            if residuals is None:
                return None
            return normalise(residuals[0], self._noise), *project_out_start(
                residuals, size, self._noise
            )

        about = []
        for one in self._rolls.map_windows(linearise_window, z, windows, starts):
            if one is None:
                return None
            about.append(one)
        H = np.zeros((len(acts), len(acts)))
        for _, B, _ in about:
            H += B.T @ B
        terms = np.zeros((len(changes), P))
        for change, row in zip(changes, terms, strict=True):
            for way in (1.0, -1.0):
                changed = z + way * change

                def roll(
                    roller: Sensitivity,
                    window: Window,
                    start: FloatArray,
                    changed: FloatArray = changed,
                ) -> FloatArray | None:
                    residuals = self._rolls.residuals(roller, window, start, changed, None)
                    return None if residuals is None else normalise(residuals[0], self._noise)

                moved = [
                    start + way * slope @ change[acts]
                    for start, (_, _, slope) in zip(starts, about, strict=True)
                ]
                rolled = self._rolls.map_windows(roll, changed, windows, moved)
                for r, (r0, B, _) in zip(rolled, about, strict=True):
                    if r is None:
                        return None
                    row[acts] += B.T @ (r - r0)
        return _scatter(_scatter(H, acts, P).T, acts, P), terms

    def window_information(
        self, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[FloatArray] | None:
        """Return H of each window at z = 0, shape (P, P) each, or None if a window diverges."""
        matrices, P, acts = [], len(self.parameters), self._acts
        for window in self._reduced_windows(np.zeros(P), windows, starts):
            if window is None:
                return None
            matrices.append(_scatter(_scatter(window.information, acts, P).T, acts, P))
        return matrices

    def _reduced_windows(
        self, z: FloatArray, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Iterator[ReducedWindow | None]:
        """Return each window with eliminated start state, or None if a window diverges."""
        self._rolls.differentiate_at(z)
        size = 2 * len(self.robot.coordinates)

        def reduce_window(
            roller: Sensitivity, window: Window, start: FloatArray
        ) -> ReducedWindow | None:
            residuals = self._rolls.residuals(roller, window, start, z, self._acts)
            return None if residuals is None else eliminate(residuals, size, self._noise)

        return self._rolls.map_windows(reduce_window, z, windows, starts)


def _scatter(columns: FloatArray, acts: IntArray, count: int) -> FloatArray:
    """Return an array with the given columns at indices `acts` and zeros elsewhere."""
    scattered = np.zeros((len(columns), count))
    scattered[:, acts] = columns
    return scattered


def _inertia_priors(
    robot: Robot, parameters: Sequence[Parameter], sd: float
) -> list[tuple[IntArray, InertiaPrior]]:
    """Return the prior of each link with free inertia, and the indices of its parameters."""
    at: dict[int, list[int]] = {}
    for k, one in enumerate(parameters):
        if one.kind == "inertia":
            at.setdefault(one.item, []).append(k)
    return [
        (np.array(rows, dtype=np.int32), InertiaPrior(thicken(robot.links[link].inertia), sd))
        for link, rows in at.items()
    ]
