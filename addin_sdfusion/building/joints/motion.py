"""Displacement of a joint by the values of its motions."""

from __future__ import annotations

from collections.abc import Iterable

from ...robot.model.rotations import axis_rotation
from ...robot.model.transform import IDENTITY, Transform
from ...snapshot import MotionSnapshot


def joint_motion(motions: Iterable[MotionSnapshot]) -> Transform:
    """Return the displacement T = m_1 · m_2 · ... of a joint located at the origin.

    Args:
        motions: Ordered motions, with axes fixed to the stationary body.
    """
    T = IDENTITY
    for motion in motions:
        if motion.kind == "rotation":
            step = Transform(axis_rotation(motion.axis, motion.value), IDENTITY.p)
        else:
            x, y, z = motion.axis
            step = Transform(IDENTITY.R, (motion.value * x, motion.value * y, motion.value * z))
        T = T.compose(step)
    return T
