"""Standard deviations due to nonlinearity: second derivatives, and effects on via points."""

from __future__ import annotations

import numpy as np
import pytest
from support.robots.recorded_arm import NOISE, ROWS, STEP, damped_arm, recording

from sim_dart.calibration.curvature import covariance_root, curvature_deviations
from sim_dart.calibration.parameters import free_parameters
from sim_dart.calibration.problem import CalibrationProblem
from sim_dart.calibration.recordings import Window, cut_windows
from sim_dart.core.arrays import FloatArray

FREE = ["muscles.cable_1.offset", "muscles.cable_1.via_points"]


def problem_of(pieces: int) -> tuple[CalibrationProblem, list[Window]]:
    """Return the calibration problem of the two-link arm, and windows without noise."""
    arm = damped_arm()
    parameters, _ = free_parameters(arm, FREE, np.ones(2))
    cut = cut_windows([recording(arm, np.zeros(4), 1, pieces, noise=0.0)], ROWS * STEP)
    return CalibrationProblem(arm, parameters, np.full(6, NOISE)), cut


@pytest.mark.slow
def test_second_derivatives_equal_finite_differences() -> None:
    """Fit the start states again at every point, and differentiate numerically."""
    problem, cut = problem_of(6)
    P = len(problem.parameters)
    z, change = np.zeros(P), np.random.default_rng(1).normal(size=P)

    def residuals(z: FloatArray) -> FloatArray:
        settled = problem.fit_windows(z, cut)
        assert settled is not None
        return np.concatenate([(left / NOISE).ravel() for left in settled.residuals])

    settled = problem.fit_windows(z, cut)
    assert settled is not None
    found = problem.second_order_terms(z, cut, settled.starts, change[None])
    assert found is not None
    h = 1e-3
    J = np.array([(residuals(h * e) - residuals(-h * e)) / (2 * h) for e in np.eye(P)]).T
    second = residuals(change) - 2.0 * residuals(z) + residuals(-change)
    scale = np.sqrt(np.diag(J.T @ J))
    np.testing.assert_allclose(found[0], J.T @ J, rtol=0, atol=1e-4 * scale.max() ** 2)
    expected = J.T @ second
    np.testing.assert_allclose(found[1][0], expected, rtol=0, atol=0.02 * np.abs(expected).max())


@pytest.mark.slow
def test_curvature_deviation_is_quadratic_in_the_linear_deviation() -> None:
    """Half the linear deviation gives a quarter of the curvature deviation."""
    problem, cut = problem_of(6)
    P = len(problem.parameters)
    settled = problem.fit_windows(np.zeros(P), cut)
    assert settled is not None
    C = 1e-4 * np.eye(P)
    whole, half = (
        curvature_deviations(problem, np.zeros(P), cut, settled.starts, share**2 * C)
        for share in (1.0, 0.5)
    )
    assert whole.max() > 0
    np.testing.assert_allclose(half, whole / 4.0, rtol=0.05, atol=1e-3 * whole.max())
    parameters, _ = free_parameters(
        problem.robot, ["muscles.*.offset", "joints.*.damping"], np.ones(2)
    )
    linear = CalibrationProblem(problem.robot, parameters, np.full(6, NOISE))
    none = curvature_deviations(linear, np.zeros(6), cut, settled.starts, np.eye(6))
    np.testing.assert_array_equal(none, 0.0)


def test_covariance_with_rounding_errors_has_a_root() -> None:
    """One direction has zero variance, which is negative due to rounding."""
    C = np.array([[1.0, 1.0 + 1e-15], [1.0 + 1e-15, 1.0]])
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(C)
    root = covariance_root(C)
    np.testing.assert_allclose(root @ root.T, C, atol=1e-14)
