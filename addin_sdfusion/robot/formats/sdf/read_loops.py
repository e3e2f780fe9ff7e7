"""Detection of loop joints in SDF models: joints whose child already has a parent joint."""

from __future__ import annotations

from collections.abc import Sequence

from ...model.joint import Coordinate, Joint
from ...model.loop import LoopJoint, loop_type
from ..reading.xml import Node
from .read_joints import Model, read_joint


def split_loops(nodes: Sequence[Node], model: Model) -> tuple[list[Joint], list[LoopJoint]]:
    """Return the joints of the tree and the loop joints.

    If several joints have the same child, the first one in the file is the tree joint. A joint
    with range 0 is the tree joint only if no other joint exists. A loop joint with range 0 becomes
    fixed.
    """
    read = [(read_joint(node, model), node) for node in nodes]
    carriers: dict[str, Joint] = {}
    for joint, _ in sorted(read, key=lambda item: _has_zero_range(item[0])):
        if joint.parent != joint.child:
            carriers.setdefault(joint.child, joint)
    loops = [
        _loop(joint, node, carriers[joint.child])
        for joint, node in read
        if carriers.get(joint.child, joint) is not joint
    ]
    names = {id(joint) for joint in carriers.values()}
    return [j for j, _ in read if id(j) in names or j.child not in carriers], loops


def _has_zero_range(joint: Joint) -> bool:
    """Return whether a joint has motions, all with the range 0 to 0."""
    return bool(joint.motions) and all(c.lower == c.upper == 0.0 for c in joint.coordinates)


def _loop(joint: Joint, node: Node, carrier: Joint) -> LoopJoint:
    motions = joint.motions
    if _has_zero_range(joint):
        motions = ()
        problem = f"closes a loop, since {carrier.name!r} already moves {joint.child!r}"
        node.warning("loop-joint-held", f"{problem}; its range is 0, so it is read as fixed")
    lost = [name for name in _WORDS if any(_has_property(c, name) for c in joint.coordinates)]
    if motions and lost:
        problem = f"closes a loop, so it has no coordinates; its {', '.join(lost)} are omitted"
        node.warning("loop-joint-forces", problem)
    kind = loop_type(motions)
    assert kind is not None, joint.name  # all joint types of SDF can close loops
    return LoopJoint(
        joint.name, joint.parent, joint.child, *kind, joint.T_parent_joint, joint.T_child_joint
    )


_WORDS = ("limits", "damping", "stiffness", "friction")


def _has_property(c: Coordinate, name: str) -> bool:
    if name == "limits":
        return c.is_limited
    return bool(getattr(c, name))
