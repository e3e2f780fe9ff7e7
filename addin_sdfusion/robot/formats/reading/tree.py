"""Order of the joints in a kinematic tree, and fixed joints for links without a joint."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ...finding import Subject
from ...model.joint import Joint
from ...model.pose import Pose
from ...model.robot import WORLD
from .xml import Node


def parents_first(joints: Sequence[Joint]) -> list[Joint]:
    """Return the joints with parents before children, otherwise in the given order.

    Joints that depend on a cycle come last; the robot check reports them.
    """
    ordered: list[Joint] = []
    waiting: dict[str, list[Joint]] = {}
    carried = {joint.child for joint in joints}
    placed = {WORLD, *(joint.parent for joint in joints if joint.parent not in carried)}
    for joint in joints:
        ready = [joint]
        while ready:
            first = ready.pop()
            if first.parent not in placed:
                waiting.setdefault(first.parent, []).append(first)
                continue
            ordered.append(first)
            placed.add(first.child)
            ready += reversed(waiting.pop(first.child, []))
    return ordered + [joint for group in waiting.values() for joint in group]


def fixed_roots(
    links: Iterable[Node], joints: Iterable[Joint], pose: Callable[[str], Pose], model: Node
) -> list[Joint]:
    """Return fixed joints to the world for all links that are not the child of a joint.

    Args:
        links: Elements of the links, with their names.
        pose: Function that returns the pose of a link in the world frame.
        model: Element of the robot.
    """
    carried = {joint.child for joint in joints}
    used_names = {joint.name for joint in joints}
    fixed: list[Joint] = []
    for node in links:
        link = node.attribute("name")
        if link in carried:
            continue
        carried.add(link)
        name = f"{WORLD}_to_{link}"
        while name in used_names:
            name += "_"
        used_names.add(name)
        node = node.with_subject(Subject("joint", name)).with_subject(Subject("link", link))
        node.warning("welded-root", f"has no parent joint; it is fixed to {WORLD!r} at its pose")
        fixed.append(Joint(name, WORLD, link, T_parent_joint=pose(link)))
    if len(fixed) > 1:
        names = ", ".join(repr(joint.child) for joint in fixed[:10])
        problem = f"has {len(fixed)} separate trees, with roots {names}; connect them with joints"
        model.warning("several-roots", problem)
    return fixed
