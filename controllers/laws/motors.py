"""Position-controlled motors that pull their muscles through springs.

    f = max(0, K (l - l0) + D l'),   l0 = l_zero - r theta

l is the path's length, l0 the length that the motor has left free: its set point. Solved for l0 it
turns forces into set points, as CASPR's `offsetGeneration` does with -f/K for the stretch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.validation import named_vector


class SpringMotors:
    """Motors of m muscles, each with a spring in series.

    Arguments of methods have shape (m,): lengths l and set points l0 in [m], rates l' = L qd, or
    l0' for speeds, in [m/s], and forces f in [N], from 0 on.

    Args:
        muscle_names: m names.
        stiffness: K, a number or shape (m,), in [N/m].
        damping: D, a number or shape (m,), in [N·s/m].
        spindle_radius: r, a number or shape (m,), in [m].

    Raises:
        InputError: A constant is out of range; the message names the muscle.

    Attributes:
        muscle_names: m names.
        stiffness, damping, spindle_radius: Shape (m,).
    """

    def __init__(
        self,
        muscle_names: Sequence[str],
        stiffness: ArrayLike,
        *,
        damping: ArrayLike = 0.0,
        spindle_radius: ArrayLike = 0.01,
    ) -> None:
        self.muscle_names = tuple(muscle_names)
        self.stiffness = named_vector("stiffness", stiffness, self.muscle_names, above=0.0)
        self.damping = named_vector("damping", damping, self.muscle_names)
        self.spindle_radius = named_vector(
            "spindle_radius", spindle_radius, self.muscle_names, above=0.0
        )

    def forces(self, lengths: FloatArray, rates: FloatArray, set_points: FloatArray) -> FloatArray:
        """f, shape (m,), in [N]; a cable only pulls."""
        pull = self.stiffness * (lengths - set_points) + self.damping * rates
        return np.maximum(pull, 0.0)

    @np.errstate(over="ignore")  # of a weak spring: a command that is not a number is rejected
    def set_points(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> FloatArray:
        """l0 that makes the forces at a length and rate, shape (m,), in [m]."""
        l0: FloatArray = lengths - (forces - self.damping * rates) / self.stiffness
        return l0

    def angles(self, set_points: FloatArray, zero: FloatArray) -> FloatArray:
        """Return angles theta of the spindles, shape (m,), in [rad]; winding up is positive.

        Args:
            set_points: l0, shape (m,), in [m].
            zero: l_zero, the set points at theta = 0, shape (m,), in [m].
        """
        theta: FloatArray = (zero - set_points) / self.spindle_radius
        return theta

    def speeds(self, rates: FloatArray) -> FloatArray:
        """Speeds theta' of the spindles, shape (m,), in [rad/s]; winding up is positive."""
        omega: FloatArray = -rates / self.spindle_radius
        return omega
