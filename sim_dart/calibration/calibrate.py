"""Calibration of a robot from recordings, with the uncertainty of each parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot
from addin_sdfusion.robot.checks.check import require_valid
from sim_dart.core.arrays import FloatArray
from sim_dart.muscles.paths import MusclePaths

from .curvature import curvature_deviations
from .fit import Fit, fit
from .fit_progress import FitProgress
from .inertia import inertia_numbers
from .markers import Marker, MarkerKinematics, poses_from_markers
from .parameters import Parameter, free_parameters
from .problem import CalibrationProblem
from .recording_check import require_same_robot
from .recordings import Recording, Window, cut_windows, measurement_noise

WINDOW = 0.08
"""Duration of a window, in [s]. It is long enough to show velocities, and so short that model
errors remain small."""

_STAGES = ((0.25, 8), (0.5, 4), (1.0, 4))
"""Fraction of each window and subsampling of windows in each stage.

Short windows keep an inaccurate model near the measurements.
"""

_STAGE_ITERATIONS = 6
_STAGE_GAIN = 3e-3
_MIN_MEASUREMENTS = 10
_MAX_WORK = 8e6
"""Largest number of derivatives times measurements. Longer recordings are subsampled evenly."""

_HELD_OUT_PART = 5
"""The last 1/5 of the windows of a single recording is held out."""

_MIN_SIGNIFICANT = 0.1
"""Error differences below this fraction of the measurement noise are not significant."""
_LIMIT_MARGIN = 2e-3
"""Margin at joint limits, in [rad] or [m], for measurement noise and inaccurate limits."""

_MAX_BEYOND_LIMIT = 0.1
"""Positions farther beyond a limit are not at the limit: markers do not determine full turns."""

_MAX_PERIOD = 0.05
"""Largest time between measurements that show velocities, in [s]."""

_GEOMETRY = ("point", "offset", "stiffness")


@dataclass(frozen=True)
class Errors:
    """RMS differences between measurements and roll-outs of short windows.

    Attributes:
        q: Errors of joint positions, shape (n,), in [rad] or [m].
        lengths: Errors of muscle lengths, shape (m,), in [m].
        markers: Errors of marker positions along the world axes, shape (3 M,), in [m].
    """

    q: FloatArray
    lengths: FloatArray
    markers: FloatArray


@dataclass(frozen=True)
class Calibration:
    """Result of a calibration.

    Attributes:
        robot: The calibrated robot.
        parameters: The free parameters.
        change: Change of each parameter, shape (P,), in its unit.
        covariance: Linearised covariance of the changes, including the prior, shape (P, P).
        curvature_sd: Additional standard deviation of each parameter due to nonlinearity,
            shape (P,); see `curvature_deviations`.
        information: Information matrix H of the measurements in units of the prior standard
            deviations, shape (P, P).
        prior: Information matrix of the prior at zero change, shape (P, P).
        misfit: Mean square of normalised residuals. The expected value is 1. A larger value scales
            the covariance.
        noise: Standard deviation of one measurement of q, lengths and markers, shape
            (n + m + 3 M,).
        before, after: Errors of the original and the calibrated robot on the calibration windows.
        held_out_before, held_out_after: Errors on the held-out windows.
        windows, held_out: Number of calibration windows and held-out windows.
        iterations: Number of iterations of the last stage.
        converged: Whether the last stage converged.
        notes: Notes for the user, one line each.
    """

    robot: Robot
    parameters: tuple[Parameter, ...]
    change: FloatArray
    covariance: FloatArray
    curvature_sd: FloatArray
    information: FloatArray
    prior: FloatArray
    misfit: float
    noise: FloatArray
    before: Errors
    after: Errors
    held_out_before: Errors
    held_out_after: Errors
    windows: int
    held_out: int
    iterations: int
    converged: bool
    notes: tuple[str, ...]

    @property
    def sd(self) -> FloatArray:
        """Standard deviations of the changes, including nonlinearity, shape (P,)."""
        return np.sqrt(np.diag(self.covariance) + self.curvature_sd**2)


def calibrate(
    robot: Robot,
    recordings: Sequence[Recording],
    patterns: Sequence[str],
    markers: Sequence[Marker] = (),
    progress: Callable[[int, int], None] | None = None,
) -> Calibration:
    """Calibrate a robot.

    Args:
        robot: The original robot.
        recordings: Recordings of its motion. The last recording, or the end of a single recording,
            is held out for validation.
        patterns: Patterns of the free parameters; see `free_parameters`.
        markers: Motion-capture markers in the recordings.
        progress: Called with the completed work and its expected total.

    Raises:
        RobotError: The robot is not valid.
        InputError: The recordings cannot identify the free parameters, or are from another robot.
        CardsflowError: The calibrated robot predicts the held-out windows worse than the original.
    """
    require_valid(robot)
    kinematics = MarkerKinematics(robot, markers) if markers else None
    if kinematics is not None:
        recordings = [_add_marker_poses(kinematics, robot, recording) for recording in recordings]
    for recording in recordings:
        _require_sensors(robot, recording)
    paths = MusclePaths(robot)
    torques = _torques(paths, recordings)
    parameters, notes = free_parameters(robot, patterns, torques, markers)
    if any(one.kind in _GEOMETRY for one in parameters):
        for recording in recordings:
            require_same_robot(robot, paths, recording)
    windows, held_out, limit_notes = _split_windows(robot, recordings)
    notes = (*notes, *limit_notes)
    spread = measurement_noise(windows)
    problem = CalibrationProblem(robot, parameters, spread, markers=kinematics)
    fitted, some, work = _fit_in_stages(problem, windows, progress)
    require_valid(problem.robot_at(fitted.z))
    result = _build_result(robot, problem, fitted, some, held_out, spread, notes)
    work.end_stage()
    _require_better(result)
    return result


def _fit_in_stages(
    problem: CalibrationProblem,
    windows: list[Window],
    progress: Callable[[int, int], None] | None,
) -> tuple[Fit, list[Window], FitProgress]:
    """Return the fit, its windows, and the progress before the evaluation of the result."""
    z = np.zeros(len(problem.parameters))
    stages = [
        _subsample(_shorten(windows, fraction)[::every], len(z)) for fraction, every in _STAGES
    ]
    some = _subsample(windows, len(z))
    work = FitProgress(progress, [*stages, some, some], _STAGE_ITERATIONS)  # last: evaluation
    for stage in stages:
        fitted = fit(problem, stage, z, _STAGE_ITERATIONS, _STAGE_GAIN, work.add_iteration)
        work.end_stage()
        problem.exclude_ineffective(fitted.information)
        z = fitted.z
    fitted = fit(problem, some, z, end_of_iteration=work.add_iteration)
    work.end_stage()
    return replace(fitted, z=problem.with_zero_friction(fitted.z)), some, work


def _build_result(
    robot: Robot,
    problem: CalibrationProblem,
    final: Fit,
    windows: list[Window],
    held_out: list[Window],
    spread: FloatArray,
    notes: tuple[str, ...],
) -> Calibration:
    P, n = len(problem.parameters), len(robot.coordinates)
    H = final.information
    _, _, prior = problem.prior(final.z)
    C = np.asarray(np.linalg.inv(H + prior), dtype=np.float64)
    count = sum(int((~np.isnan(r)).sum()) for r in final.windows.residuals)
    freedom = count - 2 * n * len(windows) - float(np.trace(H @ C))
    misfit = final.windows.cost / max(freedom, 1.0)
    C = max(misfit, 1.0) * C
    sd = problem.sd
    none = np.zeros(P)
    return Calibration(
        robot=problem.robot_at(final.z),
        parameters=problem.parameters,
        change=_changes(robot, problem, final.z),
        covariance=C * sd[:, None] * sd,
        curvature_sd=curvature_deviations(problem, final.z, windows, final.windows.starts, C) * sd,
        information=H,
        prior=problem.prior(none)[2],
        misfit=misfit,
        noise=spread,
        before=_errors(problem, none, windows),
        after=_rms(problem, final.windows.residuals),
        held_out_before=_errors(problem, none, held_out),
        held_out_after=_errors(problem, final.z, held_out),
        windows=len(windows),
        held_out=len(held_out),
        iterations=final.iterations,
        converged=final.converged,
        notes=notes,
    )


def _changes(robot: Robot, problem: CalibrationProblem, z: FloatArray) -> FloatArray:
    """Return the changes of the parameters. Changes of inertias include their thickening."""
    changes: FloatArray = z * problem.sd
    for k, one in enumerate(problem.parameters):
        if one.kind == "inertia":
            changes[k] += one.value - inertia_numbers(robot.links[one.item].inertia)[one.part[0]]
    return changes


def _errors(problem: CalibrationProblem, z: FloatArray, windows: Sequence[Window]) -> Errors:
    """Return the errors with fixed theta and fitted start states of windows."""
    fitted = problem.fit_windows(z, windows)
    beyond = [np.full(windows[0].measured.shape, np.inf)]
    return _rms(problem, beyond if fitted is None else fitted.residuals)


def _rms(problem: CalibrationProblem, residuals: Sequence[FloatArray]) -> Errors:
    n, m = len(problem.robot.coordinates), len(problem.robot.muscles)
    squares = np.concatenate(residuals) ** 2
    valid = ~np.isnan(squares)
    sums = np.where(valid, squares, 0.0).sum(axis=0)
    rms = np.sqrt(np.where(valid.any(axis=0), sums / np.maximum(valid.sum(axis=0), 1), np.nan))
    return Errors(*np.split(rms, [n, n + m]))


def _add_marker_poses(
    kinematics: MarkerKinematics, robot: Robot, recording: Recording
) -> Recording:
    """Return a recording with the poses that are determined by markers."""
    assert recording.markers is not None
    try:
        return replace(
            recording,
            completed=poses_from_markers(kinematics, robot, recording.q, recording.markers),
        )
    except InputError as error:
        raise InputError(f"{recording.name}: {error}") from None


def _require_sensors(robot: Robot, recording: Recording) -> None:
    """Reject recordings that do not contain the required measurements."""
    if recording.step > _MAX_PERIOD:
        raise InputError(
            f"{recording.name}: the time between measurements is {recording.step:.3g} s and must "
            f"be at most {_MAX_PERIOD:g} s to show velocities; record faster, with times in s"
        )
    unmeasured = [
        c.name
        for c, q in zip(robot.coordinates, recording.poses.T, strict=True)
        if np.isnan(q).all()
    ]
    if len(unmeasured) == len(robot.coordinates):
        raise InputError(
            f"{recording.name}: muscle lengths are not sufficient for calibration: an error of a "
            "muscle's path cannot be distinguished from another pose; record once with encoders at "
            "the joints, or with motion-capture markers on the links (--markers)"
        )
    if unmeasured:
        raise InputError(
            f"{recording.name}: positions of {', '.join(unmeasured)} are missing, so the paths of "
            "muscles across them are not identifiable; record once with encoders there, or with "
            "motion-capture markers on the links (--markers)"
        )
    unknown = [
        m.name
        for m, f in zip(robot.muscles, recording.tensions.T, strict=True)
        if np.isnan(f).all()
    ]
    if unknown:
        problem = (
            f"tensions and commanded forces of {', '.join(unknown)} are missing; record either"
        )
        raise InputError(f"{recording.name}: {problem}")


def _require_better(result: Calibration) -> None:
    """Reject a result that predicts the held-out windows significantly worse."""
    before, after = (
        _normalised_error(result, result.held_out_before),
        _normalised_error(result, result.held_out_after),
    )
    if not after <= 1.02 * max(before, _MIN_SIGNIFICANT):
        raise CardsflowError(
            f"the calibrated robot predicts the held-out recording worse than the original robot: "
            f"the error is {after:.3g} times the noise, not {before:.3g}; record a more varied "
            "motion"
        )


def _normalised_error(result: Calibration, errors: Errors) -> float:
    """Return the RMS of errors divided by the noise."""
    all_ = np.concatenate([errors.q, errors.lengths, errors.markers]) / result.noise
    return float(np.sqrt(np.nanmean(all_**2)))


def _split_windows(
    robot: Robot, recordings: Sequence[Recording]
) -> tuple[list[Window], list[Window], list[str]]:
    """Return calibration windows, held-out windows, and notes on ignored windows."""
    if len(recordings) > 1:
        windows, held_out = (
            cut_windows(recordings[:-1], WINDOW),
            cut_windows(recordings[-1:], WINDOW),
        )
    else:
        every = cut_windows(recordings, WINDOW)
        last = len(every) - len(every) // _HELD_OUT_PART
        windows, held_out = every[:last], every[last:]
    every = [*windows, *held_out]
    reached = dict.fromkeys(name for window in every for name in _at_limits(robot, window))
    windows, held_out = (
        [w for w in some if not _at_limits(robot, w)] for some in (windows, held_out)
    )
    for name, some in (("to calibrate from", windows), ("to hold out", held_out)):
        if len(some) < (_MIN_MEASUREMENTS if some is windows else 2):
            raise InputError(
                f"{', '.join(r.name for r in recordings)}: only {len(some)} windows of {WINDOW} s "
                f"{name} have neither gaps nor joints at their limits; record for longer"
            )
    out = len(every) - len(windows) - len(held_out)
    note = f"{out} of {len(every)} windows are ignored, because {', '.join(reached)} is at a limit"
    return windows, held_out, [note] if out else []


def _at_limits(robot: Robot, window: Window) -> list[str]:
    """Return the coordinates at a limit in a window: stops cause forces that are not measured."""
    poses = window.recording.poses[window.first : window.first + len(window.measured)]
    lower, upper = ([c.lower for c in robot.coordinates], [c.upper for c in robot.coordinates])
    beyond = np.maximum(lower - poses, poses - upper)
    at = np.any((beyond > -_LIMIT_MARGIN) & (beyond < _MAX_BEYOND_LIMIT), axis=0)
    return [c.name for c, is_at in zip(robot.coordinates, at, strict=True) if is_at]


def _shorten(windows: Sequence[Window], fraction: float) -> list[Window]:
    """Return the first part of each window."""
    rows = max(6, round(fraction * len(windows[0].measured)))
    return [window._replace(measured=window.measured[:rows]) for window in windows]


def _subsample(windows: list[Window], parameters: int) -> list[Window]:
    """Return the windows, evenly subsampled to limit the work."""
    work = parameters * sum(len(window.measured) for window in windows)
    return windows[:: max(1, round(work / _MAX_WORK))]


def _torques(paths: MusclePaths, recordings: Sequence[Recording]) -> FloatArray:
    """Return the RMS of muscle torques, shape (n,)."""
    squares = []
    for recording in recordings:
        q = recording.poses
        sound = ~np.isnan(q).any(axis=1) & ~np.isnan(recording.tensions).any(axis=1)
        rows = np.flatnonzero(sound)
        for row in rows[:: max(1, len(rows) // 100)]:
            L = paths.evaluate(q[row]).jacobian
            squares.append((L.T @ recording.tensions[row] - recording.torques[row]) ** 2)
    if not squares:
        raise InputError(f"{recordings[0].name}: no row has all positions and tensions")
    return np.asarray(np.maximum(np.sqrt(np.mean(squares, axis=0)), 1e-3))
