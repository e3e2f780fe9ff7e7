"""Pairs of links that never collide because a joint connects them."""

from __future__ import annotations

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.checks.loops import rigid_bodies

from .skeleton_group import trees


def connected_links(robot: Robot) -> set[frozenset[str]]:
    """Return the pairs of links, or of a link and `WORLD`, that are fixed or share a joint.

    Links that are connected by fixed joints form one body with common neighbours. Each kinematic
    tree is treated as a separate robot, so links of different trees are never connected.
    """
    pairs: set[frozenset[str]] = set()
    for tree in trees(robot):
        pairs |= _connected_links_of_tree(tree)
    return pairs


def _connected_links_of_tree(tree: Robot) -> set[frozenset[str]]:
    head = rigid_bodies(tree.joints)
    bodies: dict[str, list[str]] = {}
    for link, first in head.items():
        bodies.setdefault(first, []).append(link)
    neighbours = [(first, first) for first in bodies] + [
        (head[joint.parent], joint.child) for joint in tree.joints if joint.motions
    ]
    return {
        frozenset((a, b))
        for one, other in neighbours
        for a in bodies[one]
        for b in bodies[other]
        if a != b
    }
