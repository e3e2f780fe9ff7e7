"""The world of a plant without a scene."""

from __future__ import annotations

import numpy as np

from sim_dart.core.arrays import FloatArray

from .contacts import Contact


class EmptyWorld:
    """A world without objects and contacts; see `world.World`.

    Attributes:
        has_contacts: Whether there can be contacts.
        time: For messages, in [s].
    """

    has_contacts = False
    time = 0.0

    def reset(self) -> None:
        """Do nothing: there are no objects."""

    def contacts(self) -> list[Contact]:
        """None."""
        return []

    def contact_forces(self) -> FloatArray:
        """None, shape (0, 3)."""
        return np.empty((0, 3))

    def object_poses(self) -> FloatArray:
        """None, shape (0, 7)."""
        return np.empty((0, 7))

    def take_friction_error(self) -> FloatArray:
        """None, shape (0,)."""
        return np.empty(0)

    def get_state(self) -> FloatArray:
        """Return an empty state, shape (0,)."""
        return np.empty(0)

    def set_state(self, state: FloatArray) -> None:
        """Do nothing: the state is empty."""
