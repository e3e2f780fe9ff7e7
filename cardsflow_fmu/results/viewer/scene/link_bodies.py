"""Bodies of links without a mesh: capsules between joints and ends, hulls of platforms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import Link, Robot
from cardsflow_fmu.utils.arrays import FloatArray

from .motion import task_points
from .shapes import Triangles
from .solids import convex_hull

_WIDE = 0.3
"""Minimum ratio of width and length of the attachment points of a platform."""


def link_capsules(robot: Robot, link: Link) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield the end points of the capsules of a link.

    Capsules reach from the joint that moves the link to its other joints or its end, and from there
    to end-effector points.
    """
    moving = [j.T_child_joint.position for j in robot.joints if j.child == link.name]
    origin = np.array(moving[0] if moving else (0.0, 0.0, 0.0))
    ends = [np.array(link.end)] if link.end is not None else []
    if not any(end.any() for end in ends):
        children = [j for j in robot.joints if j.parent == link.name]
        ends = [np.array(j.T_parent_joint.position) for j in children]
        ends += [
            np.array(T.position)
            for loop in robot.loops
            for name, T in ((loop.parent, loop.T_parent_joint), (loop.child, loop.T_child_joint))
            if name == link.name
        ]
    yield from ((origin, end) for end in ends if np.linalg.norm(end - origin) > 1e-9)
    hub = ends[0] if ends else origin
    for frame in task_points(robot):
        tip = np.array(frame.position)
        if frame.link == link.name and np.linalg.norm(tip - hub) > 1e-9:
            yield hub, tip


def platform_hull(robot: Robot, link: Link, thickness: float) -> Triangles | None:
    """Return the convex hull of the muscle attachments of a link; None if they span no area.

    Args:
        thickness: Thickness of the hull of coplanar points, in [m].
    """
    attachments = {p.position for m in robot.muscles for p in m.via_points if p.link == link.name}
    points = np.array(sorted(attachments))
    if len(points) < 3 or not np.isfinite(points).all():
        return None
    _, extents, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if extents[1] < _WIDE * extents[0] or extents[0] == 0.0:
        return None
    offset = 0.5 * thickness * axes[2]
    if np.ptp(points @ axes[2]) < thickness:
        points = np.concatenate([points - offset, points + offset])
    return convex_hull(points)
