"""Check for recordings of other robots."""

from __future__ import annotations

import numpy as np

from sim_dart.calibration.recording_check import _spread


def test_spread_is_zero_without_values_and_nan_for_invalid_values() -> None:
    """No warning is printed. Such lengths are rejected later."""
    differences = np.array([[1.0, np.nan, np.inf], [3.0, np.nan, 0.0]])
    np.testing.assert_array_equal(_spread(differences), [1.0, 0.0, np.nan])
