"""World of a plant without a scene."""

from __future__ import annotations

import numpy as np

from sim_dart.core.arrays import FloatArray

from .contacts import Contact


class EmptyWorld:
    """World without objects and contacts; see `world.World`.

    Attributes:
        has_contacts: Always false.
        time: Current time for messages, in [s].
    """

    has_contacts = False
    time = 0.0

    def reset(self) -> None:
        """Do nothing, since no objects exist."""

    def contacts(self) -> list[Contact]:
        """Return an empty list."""
        return []

    def contact_forces(self) -> FloatArray:
        """Return an array of shape (0, 3)."""
        return np.empty((0, 3))

    def object_poses(self) -> FloatArray:
        """Return an array of shape (0, 7)."""
        return np.empty((0, 7))

    def take_friction_error(self) -> FloatArray:
        """Return an array of shape (0,)."""
        return np.empty(0)

    def get_state(self) -> FloatArray:
        """Return an empty state, shape (0,)."""
        return np.empty(0)

    def set_state(self, state: FloatArray) -> None:
        """Do nothing, since the state is empty."""
