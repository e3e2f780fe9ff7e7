"""Motion-capture markers: positions, poses from markers, and calibration with markers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.robots.recorded_arm import (
    MARKERS,
    NOISE,
    WORN,
    damped_arm,
    marker_positions,
    recording,
)

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from sim_dart.calibration.calibrate import calibrate
from sim_dart.calibration.markers import Marker, MarkerKinematics, poses_from_markers
from sim_dart.calibration.parameters import calibrated_robot, free_parameters
from sim_dart.calibration.recordings import Recording
from sim_dart.core.arrays import FloatArray


@pytest.fixture(scope="module")
def arm() -> Robot:
    return damped_arm()


def test_marker_positions_equal_closed_forms(arm: Robot) -> None:
    """Derivatives by the pose and by marker positions equal finite differences."""
    rng = np.random.default_rng(1)
    q, h = rng.uniform(-1.5, 1.5, size=(20, 2)), 1e-6
    seen = MarkerKinematics(arm, MARKERS)
    p, dp, R = seen.at(q, WORN)
    np.testing.assert_allclose(p, marker_positions(q), atol=1e-12)
    for j, step in enumerate(h * np.eye(2)):
        slope = (marker_positions(q + step) - marker_positions(q - step)) / (2 * h)
        np.testing.assert_allclose(dp[:, :, j], slope, atol=1e-9)
    for a, step in enumerate(np.eye(3)):
        moved = seen.at(q, WORN + step)[0] - p
        np.testing.assert_allclose(R[:, :, :, a].reshape(20, 9), moved, atol=1e-12)
    with pytest.raises(UnknownNameError, match="hand"):
        MarkerKinematics(arm, [Marker("tip", "hand", (0.0, 0.0, 0.0))])


def test_poses_are_determined_from_markers(arm: Robot) -> None:
    """Some markers are hidden and some joints have encoders. Undetermined joints are named."""
    seen, none = MarkerKinematics(arm, MARKERS), np.full((40, 2), np.nan)
    q = np.linspace([-1.0, 2.0], [1.2, -0.5], 40)
    markers = marker_positions(q)
    markers[5:9, 3:6] = markers[12] = np.nan
    found = poses_from_markers(seen, arm, none, markers)
    assert np.isnan(found[12]).all()
    np.testing.assert_allclose(np.delete(found, 12, 0), np.delete(q, 12, 0), atol=1e-9)
    some = q + np.array([0.01, np.nan])
    found = poses_from_markers(seen, arm, some, markers)
    np.testing.assert_array_equal(found[:, 0], some[:, 0])
    alone = marker_positions(q)
    alone[:, 3:] = np.nan
    with pytest.raises(InputError, match="do not determine joint_2; add markers on the links"):
        poses_from_markers(seen, arm, none, alone)
    with pytest.raises(InputError, match="mm away from any position that the robot can reach"):
        poses_from_markers(seen, arm, none, 1e-3 * marker_positions(q))
    for far, message in ((2.0**31, "mm away from"), (1e300, "the markers do not determine")):
        worn = [*MARKERS[:2], Marker("tip", "link_2", (0.0, far, 0.0))]
        with pytest.raises(InputError, match=message):
            poses_from_markers(MarkerKinematics(arm, worn), arm, none[:3], marker_positions(q[:3]))


def without_encoders(readings: Recording, worn: FloatArray, noise: float) -> Recording:
    """Return a recording with markers and without encoders."""
    rng, markers = np.random.default_rng(2), marker_positions(readings.q, worn)
    markers += noise * rng.normal(size=markers.shape)
    lengths = readings.lengths + NOISE * rng.normal(size=readings.lengths.shape)
    blind = np.full_like(readings.q, np.nan)
    return replace(readings, q=blind, lengths=lengths, markers=markers)


@pytest.mark.slow
def test_robot_is_calibrated_with_inaccurate_marker_positions(
    arm: Robot,
) -> None:
    """Marker positions are identified within their standard deviations."""
    hidden = np.array([3e-3, -2e-3, 1e-3, 4e-3, 0.4, -0.3])
    free = ["muscles.*.offset", "joints.*.damping"]
    parameters, _ = free_parameters(arm, free, np.ones(2))
    truth = calibrated_robot(arm, parameters, hidden)
    moved = np.array([[0.004, 0.002, -0.006], [-0.003, 0.005, 0.002], [0.006, 0.001, 0.004]])
    exact = recording(truth, hidden[:4], 1, noise=0.0)
    readings = without_encoders(exact, WORN + moved, 2e-4)
    result = calibrate(arm, [readings], [*free, "markers.*.position"], markers=MARKERS)
    everything = np.concatenate([hidden, moved.ravel()])
    assert (np.abs(result.change - everything) < 3.0 * result.sd).all()
    names = [one.name for one in result.parameters]
    along = [k for k, name in enumerate(names) if name.endswith((".x", ".z"))]
    assert result.sd[along].max() < 5e-3
    assert result.misfit < 1.3
    assert result.held_out_after.markers.max() < 4e-4
