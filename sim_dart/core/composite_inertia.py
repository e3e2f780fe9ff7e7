"""Mass properties of the links of one moving frame, as of a single body."""

from __future__ import annotations

import numpy as np

from addin_sdfusion.robot import Inertia

from .arrays import FloatArray


class CompositeInertia:
    """A rigid body made of several links.

    Attributes:
        mass: In [kg].
    """

    def __init__(self) -> None:
        self.mass = 0.0
        self._first = np.zeros(3)  # moments of mass about the frame's origin
        self._second = np.zeros((3, 3))

    @np.errstate(over="ignore", invalid="ignore")  # the core rejects what is not finite
    def add(self, inertia: Inertia, T_frame_link: FloatArray) -> None:
        """Add a link.

        Args:
            inertia: Of the link, in its own frame.
            T_frame_link: Pose of the link in the moving frame, shape (4, 4).
        """
        R, p = T_frame_link[:3, :3], T_frame_link[:3, 3]
        centre = R @ np.array(inertia.com) + p
        self.mass += inertia.mass
        self._first += inertia.mass * centre
        self._second += R @ np.array(inertia.matrix) @ R.T + _shift(inertia.mass, centre)

    @property
    def centre(self) -> FloatArray:
        """Centre of mass in the frame, shape (3,), in [m]; the origin if there is no mass."""
        return self._first / self.mass if self.mass else np.zeros(3)

    @property
    @np.errstate(over="ignore", invalid="ignore")
    def inertia(self) -> FloatArray:
        """xx, yy, zz, xy, xz, yz about the centre of mass, shape (6,), in [kg·m²]."""
        about = self._second - _shift(self.mass, self.centre)
        return about[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _shift(mass: float, r: FloatArray) -> FloatArray:
    """Return the inertia of a point mass, m (r·r 1 - r r'), shape (3, 3)."""
    moved: FloatArray = mass * (r @ r * np.eye(3) - np.outer(r, r))
    return moved
