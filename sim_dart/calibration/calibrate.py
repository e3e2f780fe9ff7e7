"""Calibration of a robot from recordings, with what they identify and what they do not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import BoolArray, FloatArray
from sim_dart.muscles.paths import MusclePaths

from .curvature import bends
from .fit import Fit, fit
from .fit_progress import FitProgress
from .inertia import inertia_numbers
from .markers import Marker, SeenMarkers, shown_poses
from .parameters import Parameter, PriorSettings, free_parameters
from .problem import CalibrationProblem
from .readings import Readings, Window, noise, windows
from .same_robot import require_this_robot

WINDOW = 0.08
"""Duration of a roll-out, in [s]: long enough for velocities, short enough for model errors."""

_STAGES = ((0.25, 8), (0.5, 4), (1.0, 4))
"""Parts of windows, and one window of so many: a model that is far off stays near the readings."""

_STAGE_ITERATIONS = 6
_STAGE_GAIN = 3e-3
_MIN_MEASUREMENTS = 10
_MAX_WORK = 8e6
"""Directions times readings: of longer recordings windows are left out evenly."""

_KEPT_OUT = 5
"""Of one recording, one of so many windows, those at its end, is kept out."""

_TELLING = 0.1
"""Errors below this part of the readings' noise do not tell robots apart."""
_NEAR_STOP = 2e-3
"""Of a limit, in [rad] or [m]: readings have noise, and stops are not where files say, quite."""

_BEYOND_STOP = 0.1
"""Poses that are farther beyond are no stop: markers show them but for whole turns."""

_SLOWEST = 0.05
"""Readings farther apart than this, in [s], show no velocities."""

_GEOMETRY = ("point", "offset", "stiffness")


@dataclass(frozen=True)
class Errors:
    """Readings less what roll-outs of short windows give, RMS.

    Attributes:
        q: Shape (n,), in [rad] or [m].
        lengths: Shape (m,), in [m].
        markers: Along the axes of the world, shape (3 M,), in [m].
    """

    q: FloatArray
    lengths: FloatArray
    markers: FloatArray


@dataclass(frozen=True)
class Calibration:
    """What a calibration gave.

    Attributes:
        robot: The calibrated robot.
        parameters: What was free.
        change: By how much each has changed, shape (P,), in its unit.
        covariance: Of the changes, with the prior, if they are small, shape (P, P).
        bend: RMS of what changes that are not small move each besides, shape (P,); see `bends`.
        information: H by the readings alone, in units of the prior's deviations, shape (P, P).
        prior: That of what was believed, where nothing had changed, shape (P, P).
        misfit: Mean square of residuals over noise: 1 is as expected, and more scales the
            covariance.
        noise: Of one reading of q, lengths and markers, shape (n + m + 3 M,).
        before, after: Errors over the recordings that it was made from.
        kept_before, kept_after: Over what was kept out.
        windows, kept: Number of windows that it was made from, and that were kept out.
        iterations: Of the last stage.
        converged: Whether they came to an end.
        notes: What is to be known besides, a line each.
    """

    robot: Robot
    parameters: tuple[Parameter, ...]
    change: FloatArray
    covariance: FloatArray
    bend: FloatArray
    information: FloatArray
    prior: FloatArray
    misfit: float
    noise: FloatArray
    before: Errors
    after: Errors
    kept_before: Errors
    kept_after: Errors
    windows: int
    kept: int
    iterations: int
    converged: bool
    notes: tuple[str, ...]

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the changes, shape (P,)."""
        return np.sqrt(np.diag(self.covariance) + self.bend**2)


def calibrate(
    robot: Robot,
    recordings: Sequence[Readings],
    free: Sequence[str],
    priors: PriorSettings | None = None,
    markers: Sequence[Marker] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Calibration:
    """Calibrate a robot.

    Args:
        robot: As it is believed to be.
        recordings: Recordings of its motion. The last of several, or the end of one, is held out
            for validation.
        free: What is free; see `free_parameters`.
        priors: How far numbers may be off.
        markers: What the recordings' markers are, where motion capture has seen some.
        progress: Called with the completed work and its expected total.

    Raises:
        RobotError: The robot is not valid.
        InputError: The recordings cannot identify what is asked for, or are of another robot.
        CardsflowError: The result predicts what was kept out worse than the robot did.
    """
    require_valid(robot)
    seen = SeenMarkers(robot, markers) if markers else None
    if seen is not None:
        recordings = [_with_shown(seen, robot, readings) for readings in recordings]
    for readings in recordings:
        _require_sensors(robot, readings)
    paths, believed = MusclePaths(robot), priors or PriorSettings()
    torques = _torques(paths, recordings)
    parameters, notes = free_parameters(robot, free, torques, believed, markers)
    if any(one.kind in _GEOMETRY for one in parameters):
        for readings in recordings:
            require_this_robot(robot, paths, readings)
    cut, kept, stopped = _kept_out(robot, recordings)
    notes = (*notes, *stopped)
    spread = noise(cut)
    problem = CalibrationProblem(robot, parameters, spread, believed.inertia, seen=seen)
    z = np.zeros(len(parameters))
    stages = [
        _bounded(_windows_of(cut, fraction)[::every], len(parameters))
        for fraction, every in _STAGES
    ]
    some = _bounded(cut, len(parameters))
    work = FitProgress(progress, [*stages, some], _STAGE_ITERATIONS)
    for stage in stages:
        found = fit(problem, stage, z, _STAGE_ITERATIONS, _STAGE_GAIN, work.add_iteration)
        work.end_stage()
        problem.skip_idle(found.information)
        z = found.z
    found = fit(problem, some, z, end_of_iteration=work.add_iteration)
    work.end_stage()
    found = replace(found, z=problem.without_traces(found.z))
    require_valid(problem.robot_at(found.z))
    result = _result(robot, problem, found, some, kept, spread, notes)
    _require_better(result)
    return result


def _result(
    robot: Robot,
    problem: CalibrationProblem,
    found: Fit,
    cut: list[Window],
    kept: list[Window],
    spread: FloatArray,
    notes: tuple[str, ...],
) -> Calibration:
    P, n = len(problem.parameters), len(robot.coordinates)
    H = found.information
    _, _, prior = problem.prior(found.z)
    C = np.asarray(np.linalg.inv(H + prior), dtype=np.float64)
    count = sum(int((~np.isnan(r)).sum()) for r in found.settled.residuals)
    freedom = count - 2 * n * len(cut) - float(np.trace(H @ C))
    misfit = found.settled.cost / max(freedom, 1.0)
    C = max(misfit, 1.0) * C
    sd = problem.sd
    none = np.zeros(P)
    return Calibration(
        robot=problem.robot_at(found.z),
        parameters=problem.parameters,
        change=_changes(robot, problem, found.z),
        covariance=C * sd[:, None] * sd,
        bend=bends(problem, found.z, cut, found.settled.starts, C) * sd,
        information=H,
        prior=problem.prior(none)[2],
        misfit=misfit,
        noise=spread,
        before=_errors(problem, none, cut),
        after=_rms(problem, found.settled.residuals),
        kept_before=_errors(problem, none, kept),
        kept_after=_errors(problem, found.z, kept),
        windows=len(cut),
        kept=len(kept),
        iterations=found.iterations,
        converged=found.converged,
        notes=notes,
    )


def _changes(robot: Robot, problem: CalibrationProblem, z: FloatArray) -> FloatArray:
    """Changes of the parameters; of inertias with what made them thick."""
    changes: FloatArray = z * problem.sd
    for k, one in enumerate(problem.parameters):
        if one.kind == "inertia":
            changes[k] += one.value - inertia_numbers(robot.links[one.item].inertia)[one.part[0]]
    return changes


def _errors(problem: CalibrationProblem, z: FloatArray, cut: Sequence[Window]) -> Errors:
    """With theta held, and windows beginning if they fit best."""
    settled = problem.settled(z, cut)
    beyond = [np.full(cut[0].measured.shape, np.inf)]
    return _rms(problem, beyond if settled is None else settled.residuals)


def _rms(problem: CalibrationProblem, residuals: Sequence[FloatArray]) -> Errors:
    n, m = len(problem.robot.coordinates), len(problem.robot.muscles)
    squares = np.concatenate(residuals) ** 2
    known = ~np.isnan(squares)
    sums = np.where(known, squares, 0.0).sum(axis=0)
    rms = np.sqrt(np.where(known.any(axis=0), sums / np.maximum(known.sum(axis=0), 1), np.nan))
    return Errors(*np.split(rms, [n, n + m]))


def _with_shown(seen: SeenMarkers, robot: Robot, readings: Readings) -> Readings:
    """Readings with the poses that markers show."""
    assert readings.markers is not None
    try:
        return replace(readings, shown=shown_poses(seen, robot, readings.q, readings.markers))
    except InputError as error:
        raise InputError(f"{readings.name}: {error}") from None


def _require_sensors(robot: Robot, readings: Readings) -> None:
    """Reject recordings from which a robot's motion cannot be known.

    Raises:
        InputError: Positions of joints or tensions are missing, or readings are too far apart.
    """
    if readings.step > _SLOWEST:
        raise InputError(
            f"{readings.name}: the time between measurements is {readings.step:.3g} s and must "
            f"be at most {_SLOWEST:g} s to show velocities; record faster, with times in s"
        )
    blind = [
        c.name
        for c, q in zip(robot.coordinates, readings.poses.T, strict=True)
        if np.isnan(q).all()
    ]
    if len(blind) == len(robot.coordinates):
        raise InputError(
            f"{readings.name}: muscle lengths are not sufficient for calibration: an error of a "
            "muscle's path cannot be distinguished from another pose; record once with encoders at "
            "the joints, or with motion-capture markers on the links (--markers)"
        )
    if blind:
        raise InputError(
            f"{readings.name}: positions of {', '.join(blind)} are missing, so the paths of the "
            "muscles across them are not identifiable; record once with encoders there, or with "
            "motion-capture markers on the links (--markers)"
        )
    mute = [
        m.name for m, f in zip(robot.muscles, readings.tensions.T, strict=True) if np.isnan(f).all()
    ]
    if mute:
        what = f"tensions and commanded forces of {', '.join(mute)} are missing; record either"
        raise InputError(f"{readings.name}: {what}")


def _require_better(result: Calibration) -> None:
    """Reject a result that predicts worse, by more than noise leaves open.

    Raises:
        CardsflowError: It does, over what was kept out.
    """
    before, after = _size(result, result.kept_before), _size(result, result.kept_after)
    if not after <= 1.02 * max(before, _TELLING):
        raise CardsflowError(
            f"the calibrated robot predicts the held-out recording worse than the original robot: "
            f"the error is {after:.3g} times the noise, not {before:.3g}; record a more varied "
            "motion"
        )


def _size(result: Calibration, errors: Errors) -> float:
    """RMS over the noise."""
    all_ = np.concatenate([errors.q, errors.lengths, errors.markers]) / result.noise
    return float(np.sqrt(np.nanmean(all_**2)))


def _kept_out(
    robot: Robot, recordings: Sequence[Readings]
) -> tuple[list[Window], list[Window], list[str]]:
    """Windows to calibrate from, those that are kept out, and a line on those left out."""
    if len(recordings) > 1:
        cut, kept = windows(recordings[:-1], WINDOW), windows(recordings[-1:], WINDOW)
    else:
        every = windows(recordings, WINDOW)
        last = len(every) - len(every) // _KEPT_OUT
        cut, kept = every[:last], every[last:]
    count, stops = len(cut) + len(kept), _Stops(robot)
    cut, kept = ([w for w in some if not stops.touched(w)] for some in (cut, kept))
    for name, some in (("to calibrate from", cut), ("to hold out", kept)):
        if len(some) < (_MIN_MEASUREMENTS if some is cut else 2):
            raise InputError(
                f"{', '.join(r.name for r in recordings)}: only {len(some)} windows of {WINDOW} s "
                f"{name} have neither gaps nor joints at their limits; record for longer"
            )
    out = count - len(cut) - len(kept)
    what = f"{out} of {count} windows are ignored, because {', '.join(stops.met)} is at a limit"
    return cut, kept, [what] if out else []


class _Stops:
    """Limits of joints, which windows may not touch: stops push by forces that nobody measures.

    Attributes:
        met: Names of those that were touched.
    """

    def __init__(self, robot: Robot) -> None:
        self._names = [c.name for c in robot.coordinates]
        self._lower = np.array([c.lower for c in robot.coordinates])
        self._upper = np.array([c.upper for c in robot.coordinates])
        self.met: list[str] = []

    def touched(self, window: Window) -> bool:
        """Return whether a joint is at a limit in a window."""
        poses = window.readings.poses[window.first : window.first + len(window.measured)]
        beyond = np.maximum(self._lower - poses, poses - self._upper)
        at: BoolArray = np.any((beyond > -_NEAR_STOP) & (beyond < _BEYOND_STOP), axis=0)
        names = [name for name, is_at in zip(self._names, at, strict=True) if is_at]
        self.met += [name for name in names if name not in self.met]
        return bool(names)


def _windows_of(cut: Sequence[Window], fraction: float) -> list[Window]:
    """Return the beginnings of windows."""
    rows = max(6, round(fraction * len(cut[0].measured)))
    return [window._replace(measured=window.measured[:rows]) for window in cut]


def _bounded(cut: list[Window], parameters: int) -> list[Window]:
    """Windows, evenly fewer if there is too much work in them."""
    work = parameters * sum(len(window.measured) for window in cut)
    return cut[:: max(1, round(work / _MAX_WORK))]


def _torques(paths: MusclePaths, recordings: Sequence[Readings]) -> FloatArray:
    """RMS of the muscles' torques, shape (n,)."""
    squares = []
    for readings in recordings:
        q = readings.poses
        sound = ~np.isnan(q).any(axis=1) & ~np.isnan(readings.tensions).any(axis=1)
        rows = np.flatnonzero(sound)
        for row in rows[:: max(1, len(rows) // 100)]:
            L = paths.evaluate(q[row]).jacobian
            squares.append((L.T @ readings.tensions[row] - readings.torques[row]) ** 2)
    if not squares:
        raise InputError(f"{recordings[0].name}: no row has all positions and tensions")
    return np.asarray(np.maximum(np.sqrt(np.mean(squares, axis=0)), 1e-3))
