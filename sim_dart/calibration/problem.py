"""Output-error calibration problem: roll-outs over short windows are fitted to measurements.

The unknowns are the parameters theta of the robot and its sensors, and the start state
x_w = (q, qd) of each window w:

    min  sum_w |r_w(theta, x_w)|^2 + prior(theta),   r_w = (y_w - y(theta, x_w)) / noise

The Levenberg-Marquardt method solves this problem. Start states are eliminated in each window. For
fixed theta, the start state of each window is fitted separately by the same method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from addin_sdfusion.robot import Robot
from sim_dart.core.arrays import FloatArray, IntArray

from .inertia import InertiaPrior, thicken
from .markers import MarkerKinematics
from .parameters import INERTIA_SD, Parameter
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
        windows: The windows. Their columns are the parameters with effect.
    """

    information: FloatArray
    gradient: FloatArray
    windows: list[ReducedWindow]


class CalibrationProblem:
    """Calibration problem of a robot.

    Args:
        robot: The original robot.
        parameters: The free parameters; empty to fit only start states.
        noise: Standard deviation of one measurement, shape (n + m + 3 M,).
        max_step: Largest step of roll-outs, in [s].
        markers: Motion-capture markers, or None.
    """

    def __init__(
        self,
        robot: Robot,
        parameters: Sequence[Parameter],
        noise: FloatArray,
        max_step: float = MAX_STEP,
        markers: MarkerKinematics | None = None,
    ) -> None:
        self.robot, self.parameters = robot, tuple(parameters)
        self._noise = noise
        self.sd = np.array([one.sd for one in parameters])
        self.low = np.array([(one.low - one.value) / one.sd for one in parameters])
        self.high = np.array([(one.high - one.value) / one.sd for one in parameters])
        self._is_friction = np.array([one.kind == "friction" for one in parameters], dtype=bool)
        self.low[self._is_friction] += _MIN_FRICTION
        self._priors = _inertia_priors(self.robot, self.parameters)
        self._rolls = RollOuts(robot, parameters, max_step, markers)
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

        places = list(zip(begin, near, strict=True))
        fitted = self._rolls.map_windows(fit_window, z, windows, places)
        if fitted is None:
            return None
        return FittedWindows(
            sum(one.cost for one in fitted),
            [one.starts[0] for one in fitted],
            [one.residuals[0] for one in fitted],
        )

    def linearise(
        self, z: FloatArray, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> Linearisation | None:
        """Return the linearisation of windows at z, or None if a window diverges."""
        reduced = self._reduced_windows(z, windows, starts)
        if reduced is None:
            return None
        g = np.zeros(len(z))
        g[self._acts] = sum(window.jacobian.T @ window.residuals for window in reduced)
        return Linearisation(self._total_information(reduced), g, reduced)

    def moved_starts(
        self,
        starts: Sequence[FloatArray],
        reduced: Sequence[ReducedWindow],
        step: FloatArray,
        *,
        fixed: float = 1.0,
    ) -> list[FloatArray]:
        """Predict the start states after a step of z.

        Args:
            starts: Start states before the step, shape (2 n,) each.
            reduced: Linearisation of the windows.
            step: Change of z, shape (P,).
            fixed: Share of the changes of the start states for fixed z.
        """
        step = step[self._acts]
        return [
            start + fixed * window.start_change + window.start_slope @ step
            for start, window in zip(starts, reduced, strict=True)
        ]

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
        reduced = self._reduced_windows(z, windows, starts)
        if reduced is None:
            return None
        terms = np.zeros(changes.shape)
        for row, change in zip(terms, changes, strict=True):
            for step in (change, -change):
                moved = self.moved_starts(starts, reduced, step, fixed=0.0)
                rolled = self._residuals(z + step, windows, moved)
                if rolled is None:
                    return None
                row[self._acts] += sum(
                    window.jacobian.T @ (r - window.residuals)
                    for window, r in zip(reduced, rolled, strict=True)
                )
        return self._total_information(reduced), terms

    def window_information(
        self, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[FloatArray] | None:
        """Return H of each window at z = 0, shape (P, P) each, or None if a window diverges."""
        reduced = self._reduced_windows(np.zeros(len(self.parameters)), windows, starts)
        if reduced is None:
            return None
        return [self._total_information([window]) for window in reduced]

    def _total_information(self, reduced: Sequence[ReducedWindow]) -> FloatArray:
        """Return the sum of H over windows, with zeros for excluded parameters, shape (P, P)."""
        H = np.zeros((len(self.parameters), len(self.parameters)))
        for window in reduced:
            H[np.ix_(self._acts, self._acts)] += window.information
        return H

    def _residuals(
        self, z: FloatArray, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[FloatArray] | None:
        """Return the normalised residuals of windows, or None if a window diverges."""

        def roll(roller: Sensitivity, window: Window, start: FloatArray) -> FloatArray | None:
            residuals = self._rolls.residuals(roller, window, start, z, None)
            return None if residuals is None else normalise(residuals[0], self._noise)

        return self._rolls.map_windows(roll, z, windows, starts)

    def _reduced_windows(
        self, z: FloatArray, windows: Sequence[Window], starts: Sequence[FloatArray]
    ) -> list[ReducedWindow] | None:
        """Return windows with eliminated start states, or None if a window diverges."""
        self._rolls.differentiate_at(z)
        size = 2 * len(self.robot.coordinates)

        def reduce_window(
            roller: Sensitivity, window: Window, start: FloatArray
        ) -> ReducedWindow | None:
            residuals = self._rolls.residuals(roller, window, start, z, self._acts)
            return None if residuals is None else eliminate(residuals, size, self._noise)

        return self._rolls.map_windows(reduce_window, z, windows, starts)


def _inertia_priors(
    robot: Robot, parameters: Sequence[Parameter]
) -> list[tuple[IntArray, InertiaPrior]]:
    """Return the prior of each link with free inertia, and the indices of its parameters."""
    at: dict[int, list[int]] = {}
    for k, one in enumerate(parameters):
        if one.kind == "inertia":
            at.setdefault(one.item, []).append(k)
    bodies = ((rows, thicken(robot.links[link].inertia)) for link, rows in at.items())
    return [
        (np.array(rows, dtype=np.int32), InertiaPrior(body, INERTIA_SD)) for rows, body in bodies
    ]
