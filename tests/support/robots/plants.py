"""Steps of plants, and their repetition from a saved state."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim_dart import Plant


def steps(plant: Plant, count: int, *inputs: Any, **more: Any) -> None:
    """Step a plant with constant inputs, those of `Plant.step`."""
    for _ in range(count):
        plant.step(*inputs, **more)


def check_repeats(plant: Plant, count: int, *inputs: Any, **more: Any) -> None:
    """Assert that steps from a saved state lead to the same state, bit by bit."""
    saved, tensions = plant.get_state(), plant.tensions
    steps(plant, count, *inputs, **more)
    first = plant.get_state()
    plant.set_state(saved)
    np.testing.assert_array_equal(plant.get_state(), saved)
    np.testing.assert_array_equal(plant.tensions, tensions)
    steps(plant, count, *inputs, **more)
    np.testing.assert_array_equal(plant.get_state(), first)
