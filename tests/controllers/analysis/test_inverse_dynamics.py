"""Tests of muscle forces along a motion and of the required muscle strength."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import planar_2r

from addin_sdfusion.robot import InputError, UnknownNameError, read_robot
from controllers import ForceDistribution
from controllers.analysis.inverse_dynamics import (
    Motion,
    motion_terms,
    size_muscles,
)
from controllers.force_distribution.methods import METHODS
from sim_dart import DartDynamics, Plant


def swing(n: int = 2, points: int = 81, size: float = 0.5, w_e: object = None) -> Motion:
    """Return a motion of sines with different phases."""
    t = np.linspace(0.0, 4.0, points)
    phase = t[:, None] * 1.5 + np.arange(n)
    q, qd, qdd = np.sin(phase), 1.5 * np.cos(phase), -2.25 * np.sin(phase)
    return Motion(t, size * q, size * qd, size * qdd, w_e)  # type: ignore[arg-type]


def test_forces_produce_the_acceleration(arm: DartDynamics) -> None:
    """In the plant, the forces produce the velocity change of the motion."""
    motion = swing(points=9)
    found = motion_terms(arm, motion).distribute()
    assert found.solved.all()
    plant = Plant(planar_2r(), step=1e-6)
    for q, qd, qdd, f in zip(motion.q, motion.qd, motion.qdd, found.forces, strict=True):
        plant.reset(q, qd)
        plant.step(f)
        np.testing.assert_allclose((plant.qd - qd) / 1e-6, qdd, atol=1e-3)


def test_forces_equal_the_forces_of_the_controller(arm: DartDynamics) -> None:
    found = motion_terms(arm, swing()).distribute()
    distribution = ForceDistribution(arm.f_min, arm.f_max)
    for L, tau, f in zip(found.terms.L, found.terms.tau, found.forces, strict=True):
        np.testing.assert_allclose(distribution.solve(L, tau).forces, f, atol=1e-6)


def test_external_loads_add_to_the_torque(arm: DartDynamics) -> None:
    load = np.full((81, 2), [1.5, -0.5])
    plain, loaded = motion_terms(arm, swing()), motion_terms(arm, swing(w_e=load))
    np.testing.assert_allclose(loaded.tau - plain.tau, load, atol=1e-12)


def test_muscle_power_equals_joint_power(arm: DartDynamics) -> None:
    found = motion_terms(arm, swing()).distribute()
    joints = np.sum(found.terms.tau * found.terms.motion.qd, axis=1)
    np.testing.assert_allclose(found.power.sum(axis=1), joints, atol=1e-7)
    assert (found.power > 0.1).any()
    assert (found.power < -0.1).any()


def test_statistics_include_only_solved_points(arm: DartDynamics) -> None:
    terms = motion_terms(arm, swing())
    weak = terms.with_bounds(None, [35.0, 100.0, 35.0, 100.0]).distribute()
    good = weak.solved
    assert 0 < good.sum() < len(good)
    f = weak.forces[good]
    np.testing.assert_allclose(weak.peaks(), f.max(axis=0))
    np.testing.assert_allclose(weak.rms(), np.sqrt((f**2).mean(axis=0)))
    times = weak.terms.motion.times[good][f.argmax(axis=0)]
    np.testing.assert_allclose(weak.peak_times(), times)
    at_min, at_max = weak.shares_at_bounds()
    np.testing.assert_allclose(at_min, (f < 10.0 + 1e-4).mean(axis=0))
    assert (at_min + at_max <= 1.0).all()
    assert (weak.margins[good] >= 0).all()
    down, up = weak.torque_margins
    assert np.array_equal(np.isnan(up[:, 0]), ~good)
    assert (down[good] >= 0).all()


@pytest.mark.slow
def test_infeasible_motion_has_nan_statistics(arm: DartDynamics) -> None:
    none = motion_terms(arm, swing()).with_bounds(10.0, 10.0).distribute()
    assert (none.distribution.status == "infeasible").all()
    for values in (none.peaks(), none.rms(), none.peak_times()):
        assert np.isnan(values).all()
    assert (none.shares_at_bounds()[0] == 0.0).all()


@pytest.mark.parametrize("method", METHODS)
def test_every_method_solves_a_motion(arm: DartDynamics, method: str) -> None:
    found = motion_terms(arm, swing(points=15)).distribute(method)
    assert found.solved.any()
    torque = -np.einsum("tmn,tm->tn", found.terms.L, found.forces)
    np.testing.assert_allclose(torque[found.solved], found.terms.tau[found.solved], atol=1e-6)


@pytest.mark.slow
def test_sized_muscles_have_the_minimum_strength(arm: DartDynamics) -> None:
    terms = motion_terms(arm, swing()).with_bounds(None, 20.0)
    sizes = size_muscles(terms, margin=0.0)
    assert not sizes.forces.solved.all()
    assert not len(sizes.impossible)
    assert terms.with_bounds(None, sizes.needed * (1 + 1e-9)).distribute().solved.all()
    np.testing.assert_allclose(sizes.needed, sizes.unlimited.peaks())
    np.testing.assert_allclose(size_muscles(terms, margin=0.5).needed, 1.5 * sizes.needed)
    min_peak = float(np.nanmax(sizes.min_peaks))
    assert sizes.critical == int(np.argmax(sizes.min_peaks))
    assert min_peak <= sizes.needed.max() + 1e-9
    assert terms.with_bounds(None, min_peak * (1 + 1e-6)).distribute().solved.all()
    assert not terms.with_bounds(None, min_peak * (1 - 1e-4)).distribute().solved.all()


@pytest.mark.slow
def test_points_that_are_infeasible_for_any_strength_are_reported(arm: DartDynamics) -> None:
    """With elbow cables on only one side, half of the motion is infeasible."""
    terms = motion_terms(arm, swing())
    L = terms.L.copy()
    L[:, 3] = L[:, 1]
    sizes = size_muscles(replace(terms, L=L))
    assert 0 < len(sizes.impossible) <= 81
    assert np.isnan(sizes.min_peaks).sum() == len(sizes.impossible)


def test_forces_of_the_left_arm_along_a_motion(shared: Path) -> None:
    robot = DartDynamics(read_robot(shared / "robots/caspr/RoboyLeftArm", "DEFAULT"))
    t = np.linspace(0, 2, 41)
    shifts = np.column_stack([0.05 * np.sin(t + k) for k in range(4)])
    rates = np.column_stack([0.05 * np.cos(t + k) for k in range(4)])
    motion = Motion(t, shifts + np.array([1.45, 0.0, 0.0, -1.3]), rates, -shifts)
    found = motion_terms(robot, motion).distribute()
    assert found.solved.all()
    down, up = found.torque_margins
    assert (down > 0).all()
    assert (up > 0).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"times": [0.0, 0.0]}, "increasing times"),
        ({"times": []}, "shape"),
        ({"q": np.zeros((3, 2))}, "of the motion has shape"),
        ({"qd": np.zeros((2, 3))}, r"qd of the motion has shape \(2, 3\)"),
        ({"qdd": [[0.0, np.nan], [0.0, 0.0]]}, "qdd of the motion must be finite"),
        ({"w_e": "no"}, "w_e of the motion must be numbers"),
    ],
)
def test_wrong_motions_raise_an_error(change: dict[str, object], message: str) -> None:
    zeros = np.zeros((2, 2))
    arguments: dict[str, object] = {"times": [0.0, 1.0], "q": zeros, "qd": zeros, "qdd": zeros}
    with pytest.raises(InputError, match=message):
        Motion(**(arguments | change))  # type: ignore[arg-type]


def test_unsuitable_motions_and_methods_raise_an_error(arm: DartDynamics) -> None:
    with pytest.raises(InputError, match="the motion has 3 coordinates, the robot has 2: joint_1"):
        motion_terms(arm, swing(3)).distribute()
    with pytest.raises(UnknownNameError, match="no force distribution 'best'"):
        motion_terms(arm, swing()).distribute("best")
    with pytest.raises(InputError, match="margin"):
        size_muscles(motion_terms(arm, swing()), margin=-0.1)
    with pytest.raises(InputError, match="f_max must be finite"):
        size_muscles(motion_terms(arm, swing()), method="puncture")
