"""Functions of coordinates, and coupled and locked coordinates: values, checks and files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.driven import ROLL, SLIDE, leg

from addin_sdfusion.robot import (
    Joint,
    PiecewiseLinear,
    Polynomial,
    Robot,
    SimmSpline,
    Term,
    check,
    read_robot,
    write_sdf,
)
from addin_sdfusion.robot.model.coupling import all_values
from addin_sdfusion.robot.model.function import derivatives, scaled, value


@pytest.mark.parametrize(
    "function",
    [SLIDE, ROLL, Polynomial((1.0, -2.0, 0.5, 0.1)), PiecewiseLinear((0.0, 1.0, 3.0), (1, 0, 4))],
)
def test_slope_is_derivative_of_value(function: SimmSpline | Polynomial | PiecewiseLinear):
    h = 1e-5
    for x in np.linspace(-3.013, 3.317, 40):
        below, here, above = (derivatives(function, x + k * h) for k in (-1, 0, 1))
        assert here[1] == pytest.approx((above[0] - below[0]) / (2 * h), abs=1e-8)
        assert here[2] == pytest.approx((above[1] - below[1]) / (2 * h), abs=1e-8)
        assert value(scaled(function, -3.0), x) == pytest.approx(-3.0 * here[0], rel=1e-14)


def test_spline_through_cubic_equals_cubic_and_is_linear_beyond():
    x = (-1.0, -0.3, 0.4, 1.1, 1.5)
    spline = SimmSpline(x, tuple(t**3 - t for t in x))
    for t in np.linspace(-1.0, 1.499, 30):
        slopes = (t**3 - t, 3 * t * t - 1, 6 * t)
        np.testing.assert_allclose(derivatives(spline, t), slopes, atol=1e-14)
    assert derivatives(spline, 2.5) == pytest.approx((1.875 + 5.75, 5.75, 0.0))
    assert derivatives(spline, -2.0) == pytest.approx((-2.0, 2.0, 0.0))


def test_coupled_coordinates_follow_in_chains():
    robot = _with_coupling(leg(), "toe", (Term("glide", Polynomial((0.0, 2.0))),))
    q = {"hip": 0.2, "flexion": -0.5, "sway": 0.0}
    glide = (
        0.02 + 0.7 * -0.5 - 0.1 * 0.25 + value(leg().all_coordinates[3].coupling[1].function, 0.2)
    )
    assert all_values(robot, q)["toe"] == pytest.approx(2 * glide, abs=1e-15)
    assert [c.name for c in leg().coordinates] == ["hip", "flexion", "sway"]


def test_sdf_restores_functions_couplings_and_locks(tmp_path: Path):
    assert not [finding for finding in check(leg()) if finding.is_error]
    write_sdf(leg(), tmp_path)
    assert read_robot(tmp_path) == leg()


@pytest.mark.parametrize(
    ("coupling", "code"),
    [
        ((Term("hpi"),), "unknown-coordinate"),
        ((Term("glide"),), "coupling-circle"),
        ((Term("hip", SimmSpline((0.0, 0.0, 1.0), (0.0, 1.0, 2.0))),), "bad-function"),
        ((Term("hip", Polynomial(())),), "bad-function"),
        ((Term("hip", PiecewiseLinear((0.0, 1e-320), (0.0, 1.0))),), "bad-function"),
    ],
)
def test_invalid_couplings_are_errors(coupling: tuple[Term, ...], code: str):
    robot = _with_coupling(leg(), "glide", coupling)
    assert code in [finding.code for finding in check(robot) if finding.is_error]


def _with_coupling(robot: Robot, name: str, coupling: tuple[Term, ...]) -> Robot:
    def changed(joint: Joint) -> Joint:
        own = (
            replace(c, coupling=coupling, locked=False) if c.name == name else c
            for c in joint.coordinates
        )
        return replace(joint, coordinates=tuple(own))

    return replace(robot, joints=tuple(map(changed, robot.joints)))
