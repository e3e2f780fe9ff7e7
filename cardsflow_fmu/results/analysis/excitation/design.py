"""Design of motions for the identification of robot parameters: Bayesian D-optimal splines.

The motion is a B-spline of fifth order. The first and last five control points are the start pose,
so that the motion begins and ends at rest. The other control points are optimised:

    max log det (H + H0),   H = sum of the information of all windows of a calibration

with the prior H0. Single control points are exchanged (Meyer & Nachtsheim 1995, Technometrics 37).
Only motions that are feasible within the force limits are accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from addin_sdfusion.robot import CardsflowError, InputError, Robot
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion, motion_terms
from sim_dart.calibration.calibrate import WINDOW
from sim_dart.calibration.parameters import Parameter, free_parameters
from sim_dart.calibration.problem import CalibrationProblem
from sim_dart.calibration.recordings import Recording, Window

from .motions import Motions
from .spline import GRID, KNOTS, ORDER

DURATION = 20.0
SPEED = 1.5
NOISE = 1e-4
"""Noise of each measurement of a position, in [rad] or [m], or length, in [m], at `READ`."""

READ = 1e-3
"""Time between two measurements of the recording that is predicted, in [s]."""

_ROWS = round(WINDOW / GRID) + 1
_FIRST = 10
"""Index of the first row of the window in a span."""

_MAX_STEP = 4e-3
_MAX_SPANS = 1000
_MAX_SPEED = 100.0

_SWEEPS = 6
_TRIES = 4
_WORK = 1.2e5
"""Maximum number of simulated windows times the number of parameters."""

_REFINED_WINDOWS = 80
"""Maximum number of windows for the final information."""


@dataclass(frozen=True)
class Excitation:
    """Motion, and the information of a recording of it.

    Attributes:
        motion: The motion from rest to rest, with rows at time steps of `GRID`.
        forces: Minimum forces of the motion, shape (T, m), in [N].
        information: H of measurements with `NOISE` at `READ`, scaled by the prior standard
            deviations, shape (P, P).
        prior: H0, scaled in the same way, shape (P, P).
        notes: Notes for users, one line each.
    """

    motion: Motion
    forces: FloatArray
    parameters: tuple[Parameter, ...]
    information: FloatArray
    prior: FloatArray
    notes: tuple[str, ...]

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of the parameters, including the prior, shape (P, P)."""
        sd = np.array([one.sd for one in self.parameters])
        C: FloatArray = np.linalg.inv(self.information + self.prior) * sd[:, None] * sd
        return C

    @property
    def sd(self) -> FloatArray:
        """Predicted standard deviations, shape (P,)."""
        return np.sqrt(np.diag(self.covariance))


def excitations(
    robot: Robot,
    start: FloatArray,
    patterns: Sequence[str],
    duration: float = DURATION,
    speed: float = SPEED,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Excitation]:
    """Yield a motion that identifies parameters, then smaller motions of the same shape.

    Args:
        robot: A valid robot; muscles or motors drive all coordinates.
        start: Pose at start and end, which the muscles can hold, shape (n,).
        patterns: Patterns of parameters, see `free_parameters`.
        duration: Duration, in [s].
        speed: Maximum speed, in [rad/s]; scaled by the robot size for sliding coordinates.
        seed: Seed of the random search.
        progress: Called with the number of completed steps of the search and their total.

    Raises:
        InputError: The robot has closed loops, or the duration or speed is out of range.
        CardsflowError: The muscles cannot move the robot from its start.
    """
    if robot.loops:
        raise InputError(f"robot {robot.name!r} has closed loops, which are not supported")
    shortest, longest = 2 * ORDER * KNOTS, _MAX_SPANS * KNOTS
    if not shortest <= duration <= longest:
        raise InputError(
            f"must be from {shortest:g} to {longest:g} s, not {duration:g}", key="--duration"
        )
    if not 0.0 < speed <= _MAX_SPEED:
        problem = f"must be above 0 and at most {_MAX_SPEED:g} rad/s, not {speed:g}"
        raise InputError(problem, key="--speed")
    motions = Motions(robot, np.asarray(start, float), round(duration / KNOTS), speed)
    rng = np.random.default_rng(seed)
    points = motions.random_motion(rng)
    torque = np.sqrt(np.mean(motions.terms(points, range(motions.spans)).tau ** 2, axis=0))
    parameters, notes = free_parameters(robot, patterns, np.maximum(torque, 1e-3))
    design = Design(motions, parameters)
    points = design.exchange(points, rng, progress)
    while True:
        points = motions.make_feasible(points)
        motion, forces = motions.whole(points)
        H = design.measured_information(motion, forces)
        yield Excitation(motion, forces, parameters, H, design.prior, notes)
        points = motions.scale_down(points)


class Design:
    """Design of motions by their information on parameters."""

    def __init__(self, motions: Motions, parameters: tuple[Parameter, ...]) -> None:
        self._motions, self._parameters = motions, parameters
        n, m = len(motions.robot.coordinates), len(motions.robot.muscles)
        self._columns = n, m
        noise = np.full(n + m, NOISE)
        share = (
            _ROWS * READ / KNOTS
        )  # the few simulated measurements represent all measurements of the span
        robot, few = motions.robot, noise * np.sqrt(share)
        self._problem = CalibrationProblem(robot, parameters, few, _MAX_STEP)
        self._exact = CalibrationProblem(robot, parameters, noise)
        self.prior = self._problem.prior(np.zeros(len(parameters)))[2]

    def exchange(
        self,
        points: FloatArray,
        rng: np.random.Generator,
        progress: Callable[[int, int], None] | None = None,
    ) -> FloatArray:
        """Improve the information of a motion by exchanging single control points.

        Args:
            rng: Source of the random proposals.
            progress: Called with the number of completed proposals and their total.
        """
        motions = self._motions
        none = np.zeros_like(self.prior)
        information = [self._information(points, span) for span in range(motions.spans)]
        spans = [none if H is None else H for H in information]
        total = self.prior + sum(spans, none)
        best = np.linalg.slogdet(total)[1]
        work = len(self._parameters) * (ORDER + 1) * len(motions.free) * _SWEEPS
        tries = int(np.clip(round(_WORK / work), 1, _TRIES))
        candidates = [k for _ in range(_SWEEPS) for k in motions.free for _ in range(tries)]
        for count, k in enumerate(candidates):
            if progress is not None:
                progress(count, len(candidates))
            new = points.copy()
            new[k] = motions.propose(points, k, rng)
            around = range(k - ORDER, k + 1)
            parts = self._all_information(new, around)
            if parts is None:
                continue
            changed = total + sum((H - spans[s] for s, H in zip(around, parts, strict=True)), none)
            gain = np.linalg.slogdet(changed)[1]
            if gain > best:
                points, total, best = new, changed, gain
                spans[around.start : around.stop] = parts
        if progress is not None:
            progress(len(candidates), len(candidates))
        return points

    def _all_information(self, points: FloatArray, spans: range) -> list[FloatArray] | None:
        """Return the information of spans; None if the muscles cannot perform the motion."""
        if np.isnan(self._motions.forces(self._motions.terms(points, spans))).any():
            return None
        information = []
        for span in spans:
            H = self._information(points, span)
            if H is None:
                return None
            information.append(H)
        return information

    def _information(self, points: FloatArray, span: int) -> FloatArray | None:
        """Return the information of a span; None if its simulation fails."""
        motions = self._motions
        motion = motions.rows(points, span, _FIRST, _ROWS + 1)
        forces = motions.forces(motion_terms(motions.dynamics, motion))
        if np.isnan(forces).any():
            return None
        window, start = self._window(motion, forces, 0, _ROWS)
        information = self._problem.window_information([window], [start])
        return None if information is None else information[0]

    def measured_information(self, motion: Motion, forces: FloatArray) -> FloatArray:
        """Return the information of measurements at `READ`, from windows of the whole motion.

        Raises:
            CardsflowError: The robot diverges within a window.
        """
        samples = _resample(motion, forces)
        rows = round(WINDOW / READ)
        firsts = np.arange(0, len(samples[0].times) - rows, rows)
        some = firsts[:: max(1, len(firsts) // _REFINED_WINDOWS)]
        windows = [self._window(*samples, int(first), rows) for first in some]
        cut, starts = [w for w, _ in windows], [s for _, s in windows]
        information = self._exact.window_information(cut, starts)
        if information is None:
            raise CardsflowError("the robot diverges along the motion")
        return np.asarray(np.sum(information, axis=0) * len(firsts) / len(some))

    def _window(
        self, motion: Motion, forces: FloatArray, first: int, rows: int
    ) -> tuple[Window, FloatArray]:
        """Return a window of the motion as a recording, and its initial state."""
        motions, (n, m) = self._motions, self._columns
        T = len(motion.times)
        tensions, torques = np.zeros((T, m)), np.zeros((T, n))
        tensions[:] = np.where(motions.passive, 0.0, forces[:, :m])
        torques[:, motions.motors] = forces[:, m:]
        step = float(motion.times[1] - motion.times[0])
        nothing = np.zeros((T, n + m))
        readings = Recording("", step, motion.q, nothing[:, n:], tensions, torques)
        start = np.concatenate([motion.q[first], motion.qd[first]])
        return Window(readings, first, nothing[first : first + rows]), start


def _resample(motion: Motion, forces: FloatArray) -> tuple[Motion, FloatArray]:
    """Resample a motion at `READ` with cubic interpolation, and its forces linearly."""
    t = motion.times
    fine = READ * np.arange(round(t[-1] / READ) + 1)
    spline = CubicHermiteSpline(t, motion.q, motion.qd)
    at = Motion(fine, spline(fine), spline(fine, 1), spline(fine, 2))
    return at, np.stack([np.interp(fine, t, f) for f in forces.T], axis=1)
