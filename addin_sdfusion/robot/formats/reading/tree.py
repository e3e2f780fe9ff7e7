"""Trees of joints: their order, and the joints that fix links without one to the world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from ...finding import Subject
from ...model.joint import Joint
from ...model.pose import Pose
from ...model.robot import WORLD
from .xml import Node


def parents_first(joints: Sequence[Joint]) -> list[Joint]:
    """Return the joints in an order with parents first that moves as few as possible.

    Those that come after a loop are last, where the check finds them.
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


def welds(
    links: Iterable[Node], joints: Iterable[Joint], pose: Callable[[str], Pose], model: Node
) -> list[Joint]:
    """Fixed joints to the world for the links that no joint carries.

    Args:
        links: The elements of the links, with their names.
        joints: The joints of the file.
        pose: Where a link is in the world, by its name.
        model: The element of the robot.
    """
    carried = {joint.child for joint in joints}
    taken = {joint.name for joint in joints}
    made: list[Joint] = []
    for node in links:
        name = node.attribute("name")
        if name in carried:
            continue
        carried.add(name)
        joint = f"{WORLD}_to_{name}"
        while joint in taken:
            joint += "_"
        taken.add(joint)
        node = node.about(Subject("joint", joint)).about(Subject("link", name))
        node.warning("welded-root", f"no joint carries it; it is fixed to {WORLD!r} where it is")
        made.append(Joint(joint, WORLD, name, T_parent_joint=pose(name)))
    if len(made) > 1:
        names = ", ".join(repr(joint.child) for joint in made[:10])
        problem = f"falls apart into {len(made)} trees, with roots {names}; add the joints between"
        model.warning("several-roots", problem)
    return made
