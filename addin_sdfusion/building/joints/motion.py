"""Displacement of a joint by the values of its motions."""

from __future__ import annotations

from collections.abc import Iterable

from ...robot.model.rotations import axis_rotation
from ...robot.model.transform import IDENTITY, Transform
from ...snapshot import MotionSnapshot


def joint_motion(motions: Iterable[MotionSnapshot]) -> Transform:
    """Return the displacement of a joint at the origin, T = m_1 · m_2 · ... of its motions.

    Args:
        motions: In their order, with axes as the body has them that does not move.
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
