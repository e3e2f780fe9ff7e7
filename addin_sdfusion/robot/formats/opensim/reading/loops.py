"""Reader of OpenSim constraints that close loops: coincident points, welded frames."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

from ....checks.loops import rigid_bodies
from ....finding import Subject
from ....model.joint import Joint
from ....model.loop import LoopJoint
from ....model.pose import Pose
from ....model.transform import IDENTITY
from ....transforms.joint_chains import Names
from ...reading.loops import End, loop_joint
from ...reading.xml import ZERO, Node
from .coordinates import COUPLER
from .document import is_true
from .frames import Frames, pose_of

POINT, WELD = "PointConstraint", "WeldConstraint"


def read_loops(
    constraints: Sequence[Node], frames: Frames, joints: Sequence[Joint]
) -> Iterator[LoopJoint]:
    """Yield the loop joints of a model; report unsupported constraints.

    Args:
        constraints: All constraints.
        frames: Frames of the model.
        joints: Joints of the tree, parents first.
    """
    names, bodies = Names(joint.name for joint in joints), rigid_bodies(joints)
    for node in constraints:
        if node.tag == COUPLER or not is_true(node, "isEnforced", True):
            continue
        given = node.attribute("name", "") or node.tag
        if node.tag not in (POINT, WELD):
            problem = (
                f"<{node.tag}> {given!r} is not supported and is ignored (known: {POINT}, "
                f"{WELD}); the motion of the robot differs"
            )
            node.warning("loop-left-out", problem)
            continue
        name = names.unique(given)
        about = node.with_subject(Subject("joint", name))
        first, second = (_end(about, frames, k) for k in ("1", "2"))
        kind: Literal["ball", "fixed"] = "ball" if node.tag == POINT else "fixed"
        loop = loop_joint(about, name, kind, (first, second), bodies)
        if loop is not None:
            yield loop


def _end(node: Node, frames: Frames, number: str) -> End:
    """Return the link at one end, and the pose of the frame in it."""
    constraint_path = f"/constraintset/{node.attribute('name', '')}"
    if node.tag == WELD:
        link, T_link_frame = frames.place(node, f"socket_frame{number}", constraint_path)
        return link, pose_of(T_link_frame)
    link, T_link_frame = frames.place(node, f"socket_body_{number}", constraint_path)
    tag = f"location_body_{number}"
    point = node.vector(tag) if node.all(tag) else ZERO
    return link, Pose(point if T_link_frame == IDENTITY else T_link_frame.apply(point))
