"""Combined mass properties of all links that are fixed to one moving frame."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Inertia

from .arrays import FloatArray


class CompositeInertia:
    """Mass properties of a rigid body that consists of several links.

    Attributes:
        mass: In [kg].
    """

    def __init__(self) -> None:
        self.mass = 0.0
        self._first = np.zeros(3)  # first moments of mass about the frame's origin
        self._second = np.zeros((3, 3))

    @np.errstate(over="ignore", invalid="ignore")  # the core rejects values that are not finite
    def add(self, inertia: Inertia, T_frame_link: FloatArray) -> None:
        """Add a link.

        Args:
            inertia: Inertia of the link, in the link frame.
            T_frame_link: Pose of the link in the moving frame, shape (4, 4).
        """
        R, p = T_frame_link[:3, :3], T_frame_link[:3, 3]
        centre = R @ np.array(inertia.com) + p
        self.mass += inertia.mass
        self._first += inertia.mass * centre
        self._second += R @ np.array(inertia.matrix) @ R.T + _shift(inertia.mass, centre)

    @property
    def moments(self) -> FloatArray:
        """Mass, first moments, and inertia xx, yy, zz, xy, xz, yz about the origin, shape (10,)."""
        second = self._second[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        return np.concatenate([[self.mass], self._first, second])

    @property
    def centre(self) -> FloatArray:
        """Centre of mass in the frame, shape (3,), in [m]; the origin if the mass is 0."""
        return self._first / self.mass if self.mass else np.zeros(3)

    @property
    @np.errstate(over="ignore", invalid="ignore")
    def inertia(self) -> FloatArray:
        """Inertia xx, yy, zz, xy, xz, yz about the centre of mass, shape (6,), in [kg·m²]."""
        about = self._second - _shift(self.mass, self.centre)
        return about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _shift(mass: float, r: FloatArray) -> FloatArray:
    """Return the inertia of a point mass at r, m ((r·r) 1 - r r'), shape (3, 3)."""
    moved: FloatArray = mass * (r @ r * np.eye(3) - np.outer(r, r))
    return moved
