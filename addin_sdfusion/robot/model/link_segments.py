"""Segments along links, from joint to joint."""

from __future__ import annotations

from .pose import Vector3
from .robot import Link, Robot

_SHORT = 1e-9  # in [m]; shorter segments have no direction


def link_segments(robot: Robot, link: Link) -> list[tuple[Vector3, Vector3]]:
    """Return the segments from the parent joint of a link to its child joints and its far end.

    Returns:
        Starts and ends in the frame of the link, in [m]; none for a link without a parent joint.
    """
    begin = [j.T_child_joint.position for j in robot.joints if j.child == link.name]
    ends = [j.T_parent_joint.position for j in robot.joints if j.parent == link.name]
    if link.end is not None and link.end not in ends:
        ends.append(link.end)
    return [
        (start, end)
        for start in begin[:1]
        for end in ends
        if sum((a - b) ** 2 for a, b in zip(start, end, strict=True)) > _SHORT**2
    ]
