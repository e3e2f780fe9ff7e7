"""Calibration: derivatives, consistent inertias, identified parameters, and rejected inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.bent_cables import with_bent_cables
from support.robots.recorded_arm import NOISE, ROWS, STEP, damped_arm, recording, roll_out

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.robot import Inertia
from sim_dart.calibration.calibrate import calibrate
from sim_dart.calibration.identifiability import identifiable
from sim_dart.calibration.inertia import (
    InertiaPrior,
    inertia_numbers,
    inertia_of,
    pseudo_inertia,
    thicken,
)
from sim_dart.calibration.parameters import calibrated_robot, free_parameters
from sim_dart.calibration.recordings import cut_windows
from sim_dart.calibration.sensitivity import Directions, Sensitivity, robot_numbers

FREE = ["muscles.*.offset", "joints.*.damping"]


@pytest.fixture(scope="module")
def arm() -> Robot:
    return damped_arm()


@pytest.mark.parametrize(
    "free",
    ["*.via_points", "links.*.inertia", "joints.*.damping", "rough", "muscles.*.friction"],
)
def test_derivatives_by_parameters_equal_finite_differences(arm: Robot, free: str) -> None:
    """Compare with central differences of roll-outs with changed robots."""
    if free in ("rough", "muscles.*.friction"):
        muscles = with_bent_cables(arm, 0.2, (0.2, -0.3)).muscles
        arm = arm.with_muscles([replace(m, presliding=0.01) for m in muscles])
        free = free.replace("rough", "*.via_points")
    parameters, _ = free_parameters(arm, [free], np.ones(2))
    parameters = parameters[::3] if len(parameters) > 4 else parameters
    start = np.array([0.2, -0.3, 1.0, -0.5])
    tensions = np.linspace(20.0, 60.0, 4) * np.ones((8, 1))

    theta0 = 0.1 * np.array([one.sd for one in parameters])
    arm_there = calibrated_robot(arm, parameters, theta0)

    def changed_robot(k: int, step: float) -> Robot:
        theta = theta0.copy()
        theta[k] += step
        return calibrated_robot(arm, parameters, theta)

    h = 1e-5
    rows = []
    for k in range(len(parameters)):
        ends = [robot_numbers(changed_robot(k, way * h)) for way in (1.0, -1.0)]
        with np.errstate(invalid="ignore"):
            rows.append(np.where(ends[0] == ends[1], 0.0, (ends[0] - ends[1]) / (2 * h)))
    none = np.full(len(rows), -1, dtype=np.int32)
    along = Directions(np.array(rows), np.zeros((0, *tensions.shape)), none)
    exact = Sensitivity(arm_there).roll(start, tensions, np.zeros((8, 2)), 1e-3, 5, along)
    assert exact is not None
    for k in range(len(parameters)):
        ends = [roll_out(changed_robot(k, way * h), start, tensions) for way in (1.0, -1.0)]
        np.testing.assert_allclose(
            exact.derivatives[:, :, k], (ends[0] - ends[1]) / (2 * h), atol=2e-8, rtol=1e-6
        )


BODY = Inertia(2.0, (0.1, 0.0, 0.2), 0.02, 0.03, 0.04, 0.001, 0.0, 0.002)


def test_inertia_numbers_are_converted_back() -> None:
    found = inertia_of(inertia_numbers(BODY))
    np.testing.assert_allclose(np.array(found.matrix), np.array(BODY.matrix), atol=1e-15)
    np.testing.assert_allclose([found.mass, *found.com], [BODY.mass, *BODY.com], atol=1e-15)
    np.testing.assert_allclose(thicken(BODY), inertia_numbers(BODY), atol=1e-15)
    point = thicken(Inertia(2.0, (0.1, 0.0, 0.2), 0.0, 0.0, 0.0))
    assert np.linalg.eigvalsh(pseudo_inertia(point))[0] > 0


@pytest.mark.slow
def test_inconsistent_inertias_have_infinite_cost() -> None:
    """Gradient and Hessian of the cost equal finite differences, and exact values at 0."""
    numbers, rng = inertia_numbers(BODY), np.random.default_rng(0)
    prior = InertiaPrior(numbers, 0.3)
    assert prior(np.zeros(10))[0] == pytest.approx(0.0, abs=1e-12)
    assert prior.sd[0] == pytest.approx(2 * 0.3 * BODY.mass)
    assert numbers @ prior(np.zeros(10))[2] @ numbers == pytest.approx(1 / 0.3**2)
    unphysical = 0
    for _ in range(200):
        change = 0.3 * prior.sd * rng.normal(size=10)
        cost, g, H = prior(change)
        moments = np.linalg.eigvalsh(np.array(inertia_of(numbers + change).matrix))
        is_physical = moments[0] > 0 and moments[2] < moments[0] + moments[1]
        is_physical &= numbers[0] + change[0] > 0
        assert np.isfinite(cost) == is_physical
        unphysical += not is_physical
        if not is_physical:
            continue
        for k in range(10):
            step = 1e-5 * prior.sd[k] * np.eye(10)[k]
            high, low = prior(change + step), prior(change - step)
            if not np.isfinite(high[0] + low[0]) or cost > 1e3:
                continue
            assert (high[0] - low[0]) / (4e-5 * prior.sd[k]) == pytest.approx(g[k], rel=1e-3)
            slope = (high[1] - low[1]) / (2e-5 * prior.sd[k])
            np.testing.assert_allclose(slope, H[k], rtol=1e-3, atol=1e-6 * np.abs(H[k]).max())
    assert 20 < unphysical < 180


@pytest.mark.slow
def test_parameters_are_identified_within_their_standard_deviations(arm: Robot) -> None:
    parameters, _ = free_parameters(arm, FREE, np.ones(2))
    hidden = np.array([3e-3, -2e-3, 1e-3, 4e-3, 0.4, -0.3])
    truth = calibrated_robot(arm, parameters, hidden)
    result = calibrate(arm, [recording(truth, hidden[:4], 1)], FREE)
    assert identifiable(result).all()
    assert np.isfinite(result.held_out_after.lengths).all()
    assert (result.held_out_after.lengths < 2 * NOISE).all()
    assert result.misfit < 1.2
    assert (np.abs(result.change - hidden) < 3.0 * result.sd).all()
    assert (result.sd[:4] < 1e-4).all()
    found = [c.damping for c in result.robot.coordinates]
    np.testing.assert_allclose(found, [1.4, 0.7], atol=float(3 * result.sd[4:].max()))


@pytest.mark.slow
def test_joint_friction_is_identified_from_a_model_without_friction(arm: Robot) -> None:
    hidden = (0.0, 0.2)
    free = ["joints.*.friction"]
    parameters, _ = free_parameters(arm, free, np.ones(2))
    truth = calibrated_robot(arm, parameters, np.array(hidden))
    result = calibrate(arm, [recording(truth, np.zeros(4), 1)], free)
    assert (np.abs(result.change - hidden) < 3.0 * result.sd).all()
    assert (result.sd < 0.01).all()
    assert result.misfit < 1.2


@pytest.mark.slow
def test_cable_friction_is_identified(arm: Robot) -> None:
    """Use parts of three windows, which start with nonzero slip states."""
    muscles = with_bent_cables(arm, 0.15, (0.2, -0.3)).muscles
    arm = arm.with_muscles([replace(m, presliding=2e-3) for m in muscles])
    free = ["muscles.*.friction"]
    parameters, _ = free_parameters(arm, free, np.ones(2))
    hidden = np.array([0.05, -0.04, 0.03, -0.02])
    truth = calibrated_robot(arm, parameters, hidden)
    result = calibrate(arm, [recording(truth, np.zeros(4), 1, noise=1e-5, rows=3 * ROWS)], free)
    assert identifiable(result).all()
    assert (np.abs(result.change - hidden) < 3.0 * result.sd).all()
    assert (result.sd < 1e-3).all()


def test_unidentifiable_parameters_are_rejected(arm: Robot) -> None:
    whole = recording(arm, np.zeros(4), 2, pieces=12)
    blind = replace(whole, q=np.full_like(whole.q, np.nan))
    with pytest.raises(
        InputError, match=r"muscle lengths are not sufficient .* encoders .* markers"
    ):
        calibrate(arm, [blind], FREE)
    one = whole.q.copy()
    one[:, 1] = np.nan
    with pytest.raises(InputError, match=r"positions of joint_2 are missing"):
        calibrate(arm, [replace(whole, q=one)], FREE)
    with pytest.raises(
        InputError, match=r"tensions and commanded forces of .* are missing; record either"
    ):
        calibrate(arm, [replace(whole, tensions=np.full_like(whole.tensions, np.nan))], FREE)
    with pytest.raises(
        InputError, match="after removing a constant offset; check that the recording is from"
    ):
        calibrate(arm, [replace(whole, lengths=whole.lengths * [1, np.nan, 2, 1])], FREE)
    crossed = whole.lengths[:, [2, 1, 0, 3]]
    with pytest.raises(InputError, match=r"'l\.cable_1' and 'l\.cable_3' look swapped"):
        calibrate(arm, [replace(whole, lengths=crossed)], FREE)
    with pytest.raises(InputError, match=r"'q\.joint_1' and 'q\.joint_2' look swapped"):
        calibrate(arm, [replace(whole, q=whole.q[:, ::-1])], FREE)
    with pytest.raises(InputError, match=r"unknown parameter .muscles\.\*\.ofset.; known: "):
        calibrate(arm, [whole], ["muscles.*.ofset"])
    with pytest.raises(InputError, match=r"the time between measurements is 5 s .* times in s"):
        calibrate(arm, [replace(whole, step=1e3 * whole.step)], FREE)
    short = replace(whole, **{k: getattr(whole, k)[:40] for k in ("q", "lengths", "tensions")})
    with pytest.raises(InputError, match="record for longer"):
        calibrate(arm, [replace(short, torques=whole.torques[:40])], FREE)
    scattered = short.q.copy()  # never all joints at the same time
    scattered[::2, 0] = scattered[1::2, 1] = np.nan
    with pytest.raises(InputError, match="no row has all positions"):
        calibrate(arm, [replace(short, q=scattered, torques=whole.torques[:40])], FREE)


def test_windows_have_no_gaps(arm: Robot) -> None:
    whole = recording(arm, np.zeros(4), 3, pieces=5)
    cut = cut_windows([whole], ROWS * STEP)
    assert len(cut) == 5
    assert all(np.isfinite(window.measured).all() for window in cut)
