"""Random numbers of many instances, drawn together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray

from cardsflow_fmu.utils.arrays import FloatArray

_INCREMENT = np.uint64(0x9E3779B97F4A7C15)
_MIX = (
    (np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)),
    (np.uint64(27), np.uint64(0x94D049BB133111EB)),
    (np.uint64(31), np.uint64(1)),
)


class Draws:
    """Streams of random numbers, one for each of n instances, by the generator SplitMix64.

    A number depends only on the seed of its instance and on its place in the stream (G. Steele et
    al., Fast splittable pseudorandom number generators, 2014). So an instance draws the same
    numbers alone and among others.

    Args:
        n: Number of instances.
    """

    def __init__(self, n: int) -> None:
        self._states = np.zeros(n, dtype=np.uint64)

    def seed(self, instance: int, seed: int | None) -> None:
        """Start the stream of a seed; None for a random one."""
        self._states[instance] = seeding.np_random(seed)[0].bit_generator.random_raw()

    def uniform(self, instances: Sequence[int] | NDArray[np.intp], count: int) -> FloatArray:
        """Return the next numbers from 0 to below 1 of instances, shape (instances, count)."""
        z = self._states[instances, None] + _INCREMENT * np.arange(count + 1, dtype=np.uint64)
        self._states[instances] = z[:, -1]
        z = z[:, 1:]
        for shift, factor in _MIX:
            z = (z ^ (z >> shift)) * factor
        return (z >> np.uint64(11)).astype(np.float64) * 2.0**-53
