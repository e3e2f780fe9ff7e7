"""Displacement of a joint by the values of its motions."""

from __future__ import annotations

from collections.abc import Iterable

from ...robot.model.transform import IDENTITY, Transform, motion_transform
from ...snapshot import MotionSnapshot


def joint_motion(motions: Iterable[MotionSnapshot]) -> Transform:
    """Return the displacement T = m_1 · m_2 · ... of a joint located at the origin.

    Args:
        motions: Ordered motions, with axes fixed to the stationary body.
    """
    T = IDENTITY
    for motion in motions:
        T = T.compose(motion_transform(motion.kind, motion.axis, motion.value))
    return T
