"""Equalities of MJCF that close loops: points that coincide, bodies that are welded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

from ...checks.check import check
from ...checks.loops import rigid_bodies
from ...finding import Subject
from ...finding_builders import unknown
from ...formats.reading.loops import End, hold_together
from ...formats.reading.xml import ZERO, Node
from ...model.loop import LoopJoint
from ...model.pose import Pose, Vector3
from ...model.robot import WORLD, Robot
from ...model.transform import Transform
from ...transforms.joint_chains import Names
from .bodies import Body
from .compiler import Compiler, of_quaternion
from .document import MAIN, Document
from .equality import CONNECT, WELD, note_exact
from .found import Pose0
from .shapes import place_of


def with_loops(
    robot: Robot, document: Document, bodies: Sequence[Body], compiler: Compiler
) -> Robot:
    """The robot with the loop joints of equalities, which hold exactly here.

    Args:
        robot: The robot; the initial values of its coordinates are MuJoCo's reference pose.
        document: The file.
        bodies: Its bodies with their sites.
        compiler: The flags of the file.
    """
    parts = document.parts("equality", CONNECT, WELD)
    nodes = [document.with_defaults(node, MAIN, "equality") for node in parts]
    nodes = [node for node in nodes if node.attribute("active", "true") != "false"]
    if not nodes or any(finding.is_error for finding in check(robot)):
        return robot
    q = {c.name: c.initial for c in robot.all_coordinates}
    sites = {
        name: (part.link, compiler.pose(part.node, place_of(part, compiler)))
        for body in bodies
        for part in body.sites
        if (name := part.node.attribute("name", ""))
    }
    reader = _LoopReader(robot, Pose0(robot, q).poses, sites)
    loops = [(node, loop) for node in nodes if (loop := reader.read(node)) is not None]
    note_exact([node for node, _ in loops], "loops")
    return replace(robot, loops=tuple(loop for _, loop in loops))


class _LoopReader:
    """Reads equalities of a robot."""

    def __init__(
        self, robot: Robot, poses: Mapping[str, Transform], sites: Mapping[str, End]
    ) -> None:
        self._bodies = rigid_bodies(robot.joints)
        self._poses, self._sites = poses, sites
        self._names = Names(joint.name for joint in robot.joints)

    def read(self, node: Node) -> LoopJoint | None:
        name = self._names.give(node.attribute("name", "") or node.tag)
        node = node.about(Subject("joint", name))
        ends = self._of_sites(node) if node.has("site1") else self._of_bodies(node)
        if ends is None:
            return None
        type_: Literal["ball", "fixed"] = "ball" if node.tag == CONNECT else "fixed"
        return hold_together(node, name, type_, ends, self._bodies)

    def _of_sites(self, node: Node) -> tuple[End, End] | None:
        """Two sites that coincide."""
        first, second = node.attribute("site1"), node.attribute("site2")
        for name in (first, second):
            if name not in self._sites:
                node.error("unknown-site", unknown("site", name, list(self._sites)))
                return None
        ends = self._sites[first], self._sites[second]
        return ends if node.tag == WELD else (_point(ends[0]), _point(ends[1]))

    def _of_bodies(self, node: Node) -> tuple[End, End] | None:
        """Two bodies held as they are at the reference pose, or as a weld's `relpose` says."""
        first, second = node.attribute("body1"), node.attribute("body2", WORLD)
        for name in (first, second):
            if name not in self._poses:
                node.error("unknown-body", unknown("body", name, list(self._poses)))
                return None
        anchor = node.vector_attribute("anchor") if node.has("anchor") else ZERO
        if node.tag == WELD:  # its anchor is one of the second body
            held = _relative_pose(node)
            if held is not None:
                return (first, held.pose()), (second, Pose(anchor))
            there, here = self._meeting(second, first, anchor)
            return here, there
        here, there = self._meeting(first, second, anchor)
        return here, _point(there)

    def _meeting(self, link: str, other: str, point: Vector3) -> tuple[End, End]:
        """A frame at a point of a link, and where that is in another one, at the reference pose."""
        T_other_link = self._poses[other].inverse().compose(self._poses[link])
        there = Transform(T_other_link.R, T_other_link.apply(point))
        return (link, Pose(point)), (other, there.pose())


def _point(end: End) -> End:
    """The same point, with the axes of its link."""
    return end[0], Pose(end[1].position)


def _relative_pose(node: Node) -> Transform | None:
    """What a weld gives as the place of its second body in the first one."""
    if not node.has("relpose"):
        return None
    x, y, z, *quaternion = node.numbers_attribute("relpose", 7)
    w, i, j, k = quaternion
    return Transform(of_quaternion((w, i, j, k)), (x, y, z)) if any(quaternion) else None
