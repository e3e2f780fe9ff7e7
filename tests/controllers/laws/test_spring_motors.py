"""Tests of motors with springs in series."""

from __future__ import annotations

import numpy as np
import pytest

from addin_sdfusion.robot import InputError
from controllers import SpringMotors


def test_motors_convert_set_points_to_angles() -> None:
    springs = SpringMotors(("a", "b"), [100.0, 200.0], spindle_radius=[0.01, 0.02])
    zero, l0 = np.array([1.0, 1.0]), np.array([0.99, 1.02])
    np.testing.assert_allclose(springs.angles(l0, zero), [1.0, -1.0])
    np.testing.assert_allclose(springs.speeds(np.array([-0.01, 0.02])), [1.0, -1.0])
    slack = springs.forces(np.array([0.9, 1.1]), np.zeros(2), np.ones(2))
    np.testing.assert_allclose(slack, [0.0, 20.0])


@pytest.mark.parametrize(
    "wrong", [{"stiffness": 0.0}, {"damping": -1.0}, {"spindle_radius": [1.0, 0.0]}]
)
def test_wrong_motors_raise_an_error(wrong: dict) -> None:
    with pytest.raises(InputError, match=next(iter(wrong))):
        SpringMotors(("a", "b"), **{"stiffness": 1.0, **wrong})
