"""Steps of plants, and checks of restored states."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np

from sim_dart import Plant


def steps(plant: Plant, count: int, *inputs: Any, **more: Any) -> None:
    """Step a plant with constant inputs, those of `Plant.step`."""
    for _ in range(count):
        plant.step(*inputs, **more)


def copies(original: Any) -> list[Any]:
    """Return a copy of an object by pickle, and a deep copy."""
    return [pickle.loads(pickle.dumps(original)), copy.deepcopy(original)]


def check_repeats(plant: Plant, count: int, *inputs: Any, **more: Any) -> None:
    """Assert that steps from a saved state, and of copies, lead to the same state, bit by bit."""
    saved, tensions, twins = plant.get_state(), plant.tensions, copies(plant)
    steps(plant, count, *inputs, **more)
    first = plant.get_state()
    plant.set_state(saved)
    np.testing.assert_array_equal(plant.get_state(), saved)
    np.testing.assert_array_equal(plant.tensions, tensions)
    steps(plant, count, *inputs, **more)
    np.testing.assert_array_equal(plant.get_state(), first)
    for twin in twins:
        np.testing.assert_array_equal(twin.tensions, tensions)
        steps(twin, count, *inputs, **more)
        np.testing.assert_array_equal(twin.get_state(), first)
