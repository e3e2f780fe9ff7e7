"""Position-controlled motors with springs in series with the muscles.

    f = max(0, K (l - l0) + D l'),   l0 = l_zero - r theta

l is the length of the muscle path. l0 is the set point of the motor: the length of the unstretched
cable. Solving for l0 converts forces to set points, like `offsetGeneration` of CASPR.

Without joint sensors, set points follow a reference if they are computed from the path lengths,
their rates and the forces of `JointSpaceController` at the reference. With joint sensors, the rates
l0' = L (qd_d + Kp (q_d - q) + Kd (qd_d - qd)) move the joints to q_d under any constant load; the
controllers of kindyn omit qd_d.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from controllers.arrays import FloatArray
from controllers.validation import named_vector


class SpringMotors:
    """Motors of m muscles, each with a spring in series.

    Arguments of methods have shape (m,): lengths l and set points l0 in [m]; rates l' = L qd, or
    l0' in `speeds`, in [m/s]; non-negative forces f in [N].

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
        """Return f, shape (m,), in [N]; zero for a slack cable."""
        pull = self.stiffness * (lengths - set_points) + self.damping * rates
        return np.maximum(pull, 0.0)

    @np.errstate(over="ignore")  # with a weak spring; commands that are not finite are rejected
    def set_points(self, lengths: FloatArray, rates: FloatArray, forces: FloatArray) -> FloatArray:
        """Return the set points l0 for forces at given lengths and rates, shape (m,), in [m]."""
        l0: FloatArray = lengths - (forces - self.damping * rates) / self.stiffness
        return l0

    def angles(self, set_points: FloatArray, zero: FloatArray) -> FloatArray:
        """Return spindle angles theta, shape (m,), in [rad]; positive angles shorten the cable.

        Args:
            set_points: l0, shape (m,), in [m].
            zero: l_zero, the set points at theta = 0, shape (m,), in [m].
        """
        theta: FloatArray = (zero - set_points) / self.spindle_radius
        return theta

    def speeds(self, rates: FloatArray) -> FloatArray:
        """Return spindle speeds theta', shape (m,), in [rad/s]; positive when shortening."""
        omega: FloatArray = -rates / self.spindle_radius
        return omega
