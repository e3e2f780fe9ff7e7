"""Renaming of the parts of a robot, and change of the frames of its links."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from ..model.joint import Coordinate, Joint
from ..model.loop import LoopJoint
from ..model.muscle import BasePulley, Muscle, ViaPoint, Wrap, WrapSurface
from ..model.pose import IDENTITY, Pose
from ..model.robot import Link, Robot, TaskFrame
from ..model.rotations import apply, compose, rotate, rotation

Rename = Callable[[str], str]

_DIRECTIONS = ("cable_entry_vector", "winch_vector", "cable_pulley_entry_vector")
"""Parameters of pulleys that are directions."""


def _unchanged(text: str) -> str:
    return text


@dataclass(frozen=True)
class PartMap:
    """New names of the parts of a robot, and new frames of its links.

    Attributes:
        link, joint, coordinate, muscle, task_frame, surface: Functions that return the new name of
            a part; `link` is also called for `WORLD`.
        mesh_uri: Function that returns the new URI of a mesh.
        frame: Function that returns the pose of the frame of a link, or of `WORLD`, in its new
            frame.
    """

    link: Rename = _unchanged
    joint: Rename = _unchanged
    coordinate: Rename = _unchanged
    muscle: Rename = _unchanged
    task_frame: Rename = _unchanged
    surface: Rename = _unchanged
    mesh_uri: Rename = _unchanged
    frame: Callable[[str], Pose] = lambda _: IDENTITY

    def apply_to(self, robot: Robot) -> Robot:
        """Return the robot with its new parts; inertias and meshes stay in their frames."""
        return self.apply_to_attached(
            replace(
                robot,
                links=tuple(map(self._link, robot.links)),
                joints=tuple(map(self._joint, robot.joints)),
            )
        )

    def apply_to_attached(self, robot: Robot) -> Robot:
        """Return the robot with new muscles, task frames, wrap surfaces and loop joints."""
        return replace(
            robot,
            cable_sets=tuple(
                replace(group, muscles=tuple(map(self._muscle, group.muscles)))
                for group in robot.cable_sets
            ),
            task_sets=tuple(
                replace(group, frames=tuple(map(self._task_frame, group.frames)))
                for group in robot.task_sets
            ),
            wrap_surfaces=tuple(map(self._surface, robot.wrap_surfaces)),
            loops=tuple(map(self._loop, robot.loops)),
        )

    def _link(self, link: Link) -> Link:
        meshes = tuple(replace(mesh, uri=self.mesh_uri(mesh.uri)) for mesh in link.meshes)
        return replace(link, name=self.link(link.name), meshes=meshes)

    def _joint(self, joint: Joint) -> Joint:
        return replace(
            joint,
            name=self.joint(joint.name),
            parent=self.link(joint.parent),
            child=self.link(joint.child),
            coordinates=tuple(map(self._coordinate, joint.coordinates)),
            T_parent_joint=compose(self.frame(joint.parent), joint.T_parent_joint),
        )

    def _coordinate(self, c: Coordinate) -> Coordinate:
        terms = (replace(term, coordinate=self.coordinate(term.coordinate)) for term in c.coupling)
        return replace(c, name=self.coordinate(c.name), coupling=tuple(terms))

    def _loop(self, loop: LoopJoint) -> LoopJoint:
        return replace(
            loop,
            name=self.joint(loop.name),
            parent=self.link(loop.parent),
            child=self.link(loop.child),
            T_parent_joint=compose(self.frame(loop.parent), loop.T_parent_joint),
            T_child_joint=compose(self.frame(loop.child), loop.T_child_joint),
        )

    def _muscle(self, muscle: Muscle) -> Muscle:
        pulley = muscle.pulley and self._pulley(muscle.pulley, muscle.via_points[0].link)
        terms = (replace(t, coordinate=self.coordinate(t.coordinate)) for t in muscle.terms)
        return replace(
            muscle,
            name=self.muscle(muscle.name),
            via_points=tuple(map(self._via_point, muscle.via_points)),
            wraps=tuple(map(self._wrap, muscle.wraps)),
            terms=tuple(terms),
            pulley=pulley,
        )

    def _pulley(self, pulley: BasePulley, link: str) -> BasePulley:
        """Return a pulley whose directions are rotated with the frame of its link."""
        T = self.frame(link)
        if not any(T.rpy):
            return pulley
        R = rotation(T.rpy)
        parameters = tuple(
            (key, rotate(R, (values[0], values[1], values[2])) if key in _DIRECTIONS else values)
            for key, values in pulley.parameters
        )
        return replace(pulley, parameters=parameters)

    def _via_point(self, point: ViaPoint) -> ViaPoint:
        T, when = self.frame(point.link), point.when
        R = rotation(T.rpy)
        moves = (
            replace(m, axis=rotate(R, m.axis), coordinate=self.coordinate(m.coordinate))
            for m in point.moves
        )
        return replace(
            point,
            link=self.link(point.link),
            position=apply(T, point.position),
            when=when and replace(when, coordinate=self.coordinate(when.coordinate)),
            moves=tuple(moves),
        )

    def _wrap(self, wrap: Wrap) -> Wrap:
        side = wrap.side_point and self._via_point(wrap.side_point)
        return replace(wrap, surface=self.surface(wrap.surface), side_point=side)

    def _task_frame(self, frame: TaskFrame) -> TaskFrame:
        T = IDENTITY if frame.is_orientation else self.frame(frame.link)
        return replace(
            frame,
            name=self.task_frame(frame.name),
            link=self.link(frame.link),
            position=apply(T, frame.position),
        )

    def _surface(self, surface: WrapSurface) -> WrapSurface:
        return replace(
            surface,
            name=self.surface(surface.name),
            link=self.link(surface.link),
            pose=compose(self.frame(surface.link), surface.pose),
        )
