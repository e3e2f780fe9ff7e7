"""Values that are not finite and vectors of wrong length raise errors that name them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support.robots.arms import TwoLinkArm

from addin_sdfusion.robot import InputError
from controllers import (
    ControlLoop,
    FlowerReference,
    ForceDistribution,
    JointSpaceController,
    OperationalSpaceController,
    Posture,
    from_bandwidth,
    inverse_kinematics,
    largest_stable_period,
    lqr,
    sampling_warning,
)

ZERO, THREE = np.zeros(2), np.zeros(3)
PLANE = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]


def joint(**settings: Any) -> JointSpaceController:
    return JointSpaceController(TwoLinkArm(), 1.0, 1.0, **settings)


def task(**settings: Any) -> OperationalSpaceController:
    return OperationalSpaceController(TwoLinkArm(), 1.0, 1.0, **settings)


def loop(period: Any = 0.01, **settings: Any) -> ControlLoop:
    return ControlLoop(joint(), TwoLinkArm.coordinate_names, period, **settings)


WRONG: dict[str, Callable[[], object]] = {
    "priorities": lambda: task(priorities=["a", "b"]),
    "posture q0": lambda: task(posture=Posture(1.0, 1.0, "abc")),
    "limit_bandwidth": lambda: task(limit_bandwidth="wide"),
    "the state of the controller": lambda: task().set_state([1.0, 2.0]),
    "weights": lambda: joint(weights="abcd"),
    "f_min": lambda: joint().set_bounds("a", "b"),
    "the state": lambda: joint().set_state("abc"),
    "correction": lambda: joint().solve(*[ZERO] * 5, correction=THREE),
    "tolerance": lambda: ForceDistribution([1.0], [2.0], tolerance=np.nan),
    "period": lambda: loop("fast"),
    "observer": lambda: loop(observer="wide"),
    "the reference has shape": lambda: loop().tick(ZERO, ZERO, np.zeros((2, 2))),
    "q has shape": lambda: loop(delay=1).tick(THREE, ZERO, np.zeros((3, 2))),
    "omega": lambda: from_bandwidth("wide"),
    "q_weight": lambda: lqr("a", 1.0),
    "no gains found": lambda: lqr(1e300, 1e-300, 1e-9),
    "kp .* and kd .* must have equal lengths": lambda: sampling_warning([1, 2], [1, 2, 3], 0.01),
    "axes": lambda: FlowerReference(THREE, "plane", 1.0, 1.0),
    "radius": lambda: FlowerReference(THREE, PLANE, "wide", 1.0),
    "petals": lambda: FlowerReference(THREE, PLANE, 1.0, 1.0, np.nan),
    "kd": lambda: largest_stable_period(1.0, "much"),
    "tolerance must": lambda: inverse_kinematics(TwoLinkArm(), ZERO, ZERO, tolerance="tight"),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_raises_an_error_that_names_it(name: str) -> None:
    with pytest.raises(InputError, match=name):
        WRONG[name]()


@pytest.mark.parametrize(
    ("kp", "kd", "limit"),
    [(2000.0, 1e-200, 2e-200 / 6e3), (1e-200, 1e200, 1e-200), (1.0, 1e-9, 2e-9 / 3.0)],
)
def test_gains_of_different_magnitude_have_a_largest_stable_period(
    kp: float, kd: float, limit: float
) -> None:
    """The limit is 2/3 Kd/Kp for stiff loops with little damping, and 1/Kd for other loops."""
    assert largest_stable_period(kp, kd, 1) == pytest.approx(limit, rel=1e-9)
