"""Capsules for links without a mesh, between their joints and ends."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import Link, Robot
from cardsflow_fmu.utils.arrays import FloatArray

from .motion import task_points


def link_capsules(robot: Robot, link: Link) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Both ends of a link's capsules: to its end or its child joints, and on to its task points."""
    origin = np.zeros(3)
    ends = [np.array(link.end)] if link.end is not None else []
    if not any(end.any() for end in ends):
        children = [j for j in robot.joints if j.parent == link.name]
        ends = [np.array(j.T_parent_joint.position) for j in children]
    yield from ((origin, end) for end in ends if end.any())
    hub = ends[0] if ends else origin
    for frame in task_points(robot):
        tip = np.array(frame.position)
        if frame.link == link.name and np.linalg.norm(tip - hub) > 1e-9:
            yield hub, tip
