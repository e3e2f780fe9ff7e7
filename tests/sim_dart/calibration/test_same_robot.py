"""Recordings of other robots."""

from __future__ import annotations

import numpy as np

from sim_dart.calibration.same_robot import _spread


def test_the_spread_of_what_was_not_read_is_none_and_of_what_is_no_length_no_number() -> None:
    """Without a warning; the robot that such lengths are of is rejected later."""
    differences = np.array([[1.0, np.nan, np.inf], [3.0, np.nan, 0.0]])
    np.testing.assert_array_equal(_spread(differences), [1.0, 0.0, np.nan])
