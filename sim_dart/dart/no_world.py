"""The surroundings of a plant that has none."""

from __future__ import annotations

import numpy as np

from sim_dart.core.arrays import FloatArray

from .contacts import Contact


class NoWorld:
    """Nothing around a robot; the verbs of `world.World`.

    Attributes:
        has_contacts: Whether anything may touch anything.
        time: For messages, in [s].
    """

    has_contacts = False
    time = 0.0

    def reset(self) -> None:
        """Nothing is put anywhere."""

    def contacts(self) -> list[Contact]:
        """None."""
        return []

    def contact_forces(self) -> FloatArray:
        """None, shape (0, 3)."""
        return np.empty((0, 3))

    def object_poses(self) -> FloatArray:
        """None, shape (0, 7)."""
        return np.empty((0, 7))

    def get_state(self) -> FloatArray:
        """Nothing to remember, shape (0,)."""
        return np.empty(0)

    def set_state(self, state: FloatArray) -> None:
        """Nothing to go back to."""
