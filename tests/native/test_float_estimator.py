"""Accuracy of the estimator in single precision."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.native.precision import Handle, Precision, open_robot, room
from support.robots.estimated import STEP, Truth
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from sim_dart.estimation.estimated_robot import estimated_robot
from sim_dart.estimation.estimator import PoseEstimator
from sim_dart.estimation.settings import EstimatorSettings

TICKS = 400
START = np.array([1.45, 0.1, -0.1, -1.2])
COPIED = (
    *("length_noise", "gate", "slack", "acceleration_noise", "load_drift"),
    *("search", "starts", "start", "start_low", "start_high", "start_sd"),
    *("largest_sd", "largest_innovation", "innovation_time"),
)
HORIZON = ("huber", "low", "high")


def open_estimator(precision: Precision, like: PoseEstimator) -> Handle:
    """Open an estimator in that precision with the settings of another one."""
    robot = open_robot(precision, estimated_robot(like.robot))
    memory = room(precision.call("estimator_size", robot.pointer, 0, 0))
    pointer = precision.call("estimator_open", robot.pointer, 0, None, 0, memory)
    estimator = Handle(precision, "estimator", pointer)
    is_horizon, frames = like.settings.type == "horizon", like.settings.frames
    more = room(precision.call("estimator_horizon_size", robot.pointer, 0, 0, frames))
    assert not is_horizon or not estimator.call("use_horizon", frames, more)
    estimator.memory = robot, memory, more  # type: ignore[attr-defined]
    for name in (*COPIED, *HORIZON) if is_horizon else COPIED:
        estimator.array(name)[:] = like.array(name, -1)
    estimator.call("reset")
    return estimator


@pytest.mark.slow
def test_single_precision_has_the_same_errors(tmp_path: Path) -> None:
    """The arm swings, pulled by all muscles: errors agree with double precision."""
    arm = read_robot(EXAMPLES / "roboy_left_arm" / "robot")
    settings = EstimatorSettings(exact_transition=False, acceleration_noise=0.5, load_drift=0.5)
    double = PoseEstimator(arm, settings, START)
    precision = Precision(tmp_path, single=True)
    for name in ("estimator_size", "estimator_horizon_size"):
        getattr(precision.library, name).restype = precision.library.core_size.restype
    for name in ("estimator_open", "estimator_array"):
        getattr(precision.library, name).restype = precision.library.core_open.restype
    horizon = PoseEstimator(arm, replace(settings, type="horizon", joint_limits=False), START)
    singles = open_estimator(precision, double), open_estimator(precision, horizon)
    single, truth, n, errors = singles[0], Truth(arm, settings, START, 3), 4, []
    f = np.full(11, 60.0)
    for _ in range(TICKS):
        truth.step(f)
        truth.measure(double, f)
        assert double.tick(STEP)
        for other in singles:
            other.array("lengths")[:], other.array("tensions")[:] = double.lengths, f
            assert other.call("tick", STEP, 1) == 1
        estimates = double.q.copy(), *(other.array("state")[:n] for other in singles)
        errors.append([q - truth.q for q in estimates])
    own, *others = np.sqrt(np.mean(np.square(errors), axis=0))
    assert all((other < 1.1 * own).all() for other in others)
    assert singles[1].array("valid")[0]
    assert np.allclose(single.array("sd")[:n], double.sd[:n], rtol=0.02)
    single.array("lengths")[:] = double.path_lengths(START)
    single.array("start")[:] = START + np.array([0.1, 1.5, 0.2, 0.8])
    assert single.call("find") == 1
    assert np.allclose(single.array("state")[:n], START, atol=0.01)
