"""Excitation motions: splines, limits, and more information than sines."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from support.cases import LONG
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu.results.analysis.excitation.design import Design, excitations
from cardsflow_fmu.results.analysis.excitation.motions import Motions
from cardsflow_fmu.results.analysis.excitation.spline import GRID, KNOTS, ORDER, PER_SPAN, basis
from controllers.analysis.inverse_dynamics import Motion, motion_terms

FREE = ["muscles.*.via_points", "joints.*.damping"]
DURATION, SPEED = 8.0, 1.5
START = np.array([-0.5, 0.5])


def test_splines_reproduce_polynomials_with_correct_derivatives() -> None:
    """Control points k D give a straight line with a delay; derivatives match differences."""
    rng = np.random.default_rng(0)
    B, dB, ddB = (basis(order) for order in range(3))
    assert B.shape == (PER_SPAN + 1, ORDER + 1)
    np.testing.assert_allclose(B.sum(axis=1), 1.0, atol=1e-15)
    line = KNOTS * (np.arange(ORDER + 1) - (ORDER - 1) / 2)
    np.testing.assert_allclose(B @ line, GRID * np.arange(PER_SPAN + 1), atol=1e-14)
    np.testing.assert_allclose(dB @ line, 1.0, atol=1e-13)
    c = rng.normal(size=ORDER + 1)
    for f, df in ((B, dB), (dB, ddB)):
        slope = ((f @ c)[2:] - (f @ c)[:-2]) / (2 * GRID)
        np.testing.assert_allclose(slope, (df @ c)[1:-1], atol=0.02 * np.abs(df @ c).max())
    after = basis(1)  # the spans are continuous
    d = rng.normal(size=ORDER + 2)
    np.testing.assert_allclose(after[-1] @ d[:-1], after[0] @ d[1:], atol=1e-12)


@LONG
@pytest.mark.slow
def test_designed_motion_has_more_information_than_sines() -> None:
    """Compared by log det of information and prior, with equal limits of motion and force."""
    robot = planar_2r()
    designed = next(islice(excitations(robot, START, FREE, DURATION, SPEED), 1))
    m = designed.motion
    np.testing.assert_allclose(m.q[[0, -1]], [START, START], atol=1e-12)
    np.testing.assert_allclose(m.qd[[0, -1]], 0.0, atol=1e-12)
    assert np.abs(m.qd).max() <= SPEED
    np.testing.assert_allclose(m.qd[1:-1], (m.q[2:] - m.q[:-2]) / (2 * GRID), atol=5e-3)
    low, high = np.array([(c.lower, c.upper) for c in robot.coordinates]).T
    assert ((m.q > low) & (m.q < high)).all()
    f_min, f_max = np.array([(one.f_min, one.f_max) for one in robot.muscles]).T
    assert ((designed.forces >= f_min - 1e-9) & (designed.forces <= f_max)).all()

    motions = Motions(robot, START, round(DURATION / KNOTS), SPEED)
    design = Design(motions, designed.parameters)

    def log_det(information: np.ndarray) -> float:
        return float(np.linalg.slogdet(information + design.prior)[1])

    information = []
    for size in 0.8 ** np.arange(12):  # the largest feasible sines
        w = 2 * np.pi * np.array([0.4, 0.6])
        t, s = m.times[:, None], np.sin(w * m.times[:, None])
        A = size * SPEED / w
        sine = Motion(m.times, START + A * s, A * w * np.cos(w * t), -A * w**2 * s)
        forces = motions.forces(motion_terms(motions.dynamics, sine))
        if np.isfinite(forces).all():
            information.append(log_det(design.measured_information(sine, forces)))
    assert information
    assert log_det(designed.information) > max(information) + 2.0


def test_invalid_design_options_are_rejected() -> None:
    robot = planar_2r()
    for duration, speed in ((1.0, SPEED), (1e4, SPEED), (DURATION, 0.0), (DURATION, np.nan)):
        with pytest.raises(InputError, match=r"must be .* not"):
            next(excitations(robot, START, FREE, duration, speed))
    with pytest.raises(InputError, match=r"unknown parameter 'muscles\.\*\.ofset'"):
        next(excitations(robot, START, ["muscles.*.ofset"], DURATION, SPEED))
