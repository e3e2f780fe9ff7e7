"""Plane of a motion, from which a page chooses its first view."""

from __future__ import annotations

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform

from .stage import Stage

_PARALLEL = 1e-3


def motion_plane(stage: Stage) -> FloatArray | None:
    """Return the normal of the plane in which a planar robot moves; None for other robots.

    A robot is planar if all rotations are about parallel axes, and all translations are
    perpendicular to these axes.
    """
    turns: list[FloatArray] = []
    slides: list[FloatArray] = []
    for joint in stage.robot.joints:
        R = stage.poses[joint.parent][0, :3, :3] @ transform(joint.T_parent_joint)[:3, :3]
        for motion in joint.motions:
            axis = R @ np.array(motion.axis) / np.linalg.norm(motion.axis)
            (slides if motion.kind == "translation" else turns).append(axis)
    if not turns:
        return None
    normal = turns[0]
    parallel = all(np.linalg.norm(np.cross(axis, normal)) < _PARALLEL for axis in turns)
    within = all(abs(axis @ normal) < _PARALLEL for axis in slides)
    return normal if parallel and within and np.isfinite(normal).all() else None
