"""Several robots as one: trees on one world, with the robots' names before those of parts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import InputError
from ..mesh_files import mesh_file
from ..model.joint import Joint, renamed
from ..model.loop import LoopJoint
from ..model.muscle import BasePulley, CableSet, Muscle, ViaPoint, Wrap, WrapSurface
from ..model.muscle_path import PointMotion
from ..model.pose import IDENTITY, Pose, Vector3
from ..model.robot import WORLD, Link, Robot, TaskFrame, TaskSet
from ..model.rotations import apply, compose, rotate, rotation

_DIRECTIONS = ("cable_entry_vector", "winch_vector", "cable_pulley_entry_vector")
"""The parameters of pulleys that are directions."""


@dataclass(frozen=True)
class Member:
    """A robot among several.

    Attributes:
        name: Its name; all its parts are called `<name>_<part>`.
        robot: The robot.
        pose: Of its world in the common one.
        folder: Folder of its mesh files; None if its URIs are to stay as they are.
        roots: Other folders and files that its meshes may lie in; see `mesh_files.lies_in`.
    """

    name: str
    robot: Robot
    pose: Pose = IDENTITY
    folder: Path | None = None
    roots: tuple[Path, ...] = ()

    def named(self, part: str) -> str:
        """Return the name of one of its parts among those of all robots."""
        return part if part == WORLD else f"{self.name}_{part}"


def combine(name: str, members: Sequence[Member]) -> Robot:
    """Several robots as one.

    Its coordinates, muscles and task coordinates are those of the members' active sets, member
    after member.

    Raises:
        InputError: There are none, two have the same name or parts that come to have the same, or
            they live under different gravity.
    """
    if not members:
        raise InputError("no robots to combine; name at least one")
    _refuse_equal("robots", [member.name for member in members])
    gravities = {member.robot.gravity for member in members}
    if len(gravities) > 1:
        listed = ", ".join(f"{member.name} {member.robot.gravity}" for member in members)
        raise InputError(f"the robots have different gravity ({listed}); use the same for all")
    links = tuple(_link(link, member) for member in members for link in member.robot.links)
    joints = tuple(_joint(joint, member) for member in members for joint in member.robot.joints)
    muscles = tuple(_muscle(m, member) for member in members for m in member.robot.muscles)
    frames = tuple(_frame(f, member) for member in members for f in member.robot.task_frames)
    surfaces = tuple(_surface(s, member) for member in members for s in member.robot.wrap_surfaces)
    loops = tuple(_loop(loop, member) for member in members for loop in member.robot.loops)
    _refuse_equal("links", [link.name for link in links])
    _refuse_equal("joints", [*(joint.name for joint in joints), *(loop.name for loop in loops)])
    _refuse_equal("coordinates", [c.name for joint in joints for c in joint.coordinates])
    _refuse_equal("muscles", [muscle.name for muscle in muscles])
    _refuse_equal("task frames", [frame.name for frame in frames])
    _refuse_equal("wrap surfaces", [surface.name for surface in surfaces])
    return Robot(
        name,
        links,
        joints,
        (CableSet("all", muscles),) if muscles else (),
        "all" if muscles else "",
        (TaskSet("all", frames),) if frames else (),
        "all" if frames else "",
        gravities.pop(),
        surfaces,
        loops,
    )


def _refuse_equal(what: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"two {what} would be called {name!r}; rename a robot")
        seen.add(name)


def _link(link: Link, member: Member) -> Link:
    meshes = link.meshes
    if member.folder is not None:
        folder = member.folder.resolve()
        files = [mesh_file(mesh.uri, folder, (folder, *member.roots)) for mesh in meshes]
        meshes = tuple(
            replace(mesh, uri=str(file)) for mesh, file in zip(meshes, files, strict=True)
        )
    return replace(link, name=member.named(link.name), meshes=meshes)


def _joint(joint: Joint, member: Member) -> Joint:
    return replace(
        joint,
        name=member.named(joint.name),
        parent=member.named(joint.parent),
        child=member.named(joint.child),
        coordinates=tuple(renamed(c, member.named) for c in joint.coordinates),
        T_parent_joint=_placed(joint.parent, joint.T_parent_joint, member),
    )


def _loop(loop: LoopJoint, member: Member) -> LoopJoint:
    return replace(
        loop,
        name=member.named(loop.name),
        parent=member.named(loop.parent),
        child=member.named(loop.child),
        T_parent_joint=_placed(loop.parent, loop.T_parent_joint, member),
        T_child_joint=_placed(loop.child, loop.T_child_joint, member),
    )


def _muscle(muscle: Muscle, member: Member) -> Muscle:
    points = tuple(_via_point(point, member) for point in muscle.via_points)
    wraps = tuple(_wrap(wrap, member) for wrap in muscle.wraps)
    terms = tuple(replace(t, coordinate=member.named(t.coordinate)) for t in muscle.terms)
    pulley = muscle.pulley
    if pulley is not None and muscle.via_points[0].link == WORLD:
        pulley = _turned(pulley, member)
    name = member.named(muscle.name)
    path = {"via_points": points, "wraps": wraps, "terms": terms}
    return replace(muscle, name=name, pulley=pulley, **path)  # type: ignore[arg-type]


def _via_point(point: ViaPoint, member: Member) -> ViaPoint:
    when = point.when
    return replace(
        point,
        link=member.named(point.link),
        position=_point(point.link, point.position, member),
        when=when and replace(when, coordinate=member.named(when.coordinate)),
        moves=tuple(_point_motion(point.link, move, member) for move in point.moves),
    )


def _point_motion(link: str, move: PointMotion, member: Member) -> PointMotion:
    R = rotation(member.pose.rpy)
    axis = rotate(R, move.axis) if link == WORLD else move.axis
    return replace(move, axis=axis, coordinate=member.named(move.coordinate))


def _wrap(wrap: Wrap, member: Member) -> Wrap:
    side = wrap.side_point
    named = member.named(wrap.surface)
    return replace(wrap, surface=named, side_point=side and _via_point(side, member))


def _turned(pulley: BasePulley, member: Member) -> BasePulley:
    """Return a pulley on a robot's world, its directions turned with that world."""
    R = rotation(member.pose.rpy)
    parameters = tuple(
        (key, rotate(R, (values[0], values[1], values[2])) if key in _DIRECTIONS else values)
        for key, values in pulley.parameters
    )
    return replace(pulley, parameters=parameters)


def _frame(frame: TaskFrame, member: Member) -> TaskFrame:
    return replace(
        frame,
        name=member.named(frame.name),
        link=member.named(frame.link),
        position=_point(frame.link, frame.position, member),
    )


def _surface(surface: WrapSurface, member: Member) -> WrapSurface:
    return replace(
        surface,
        name=member.named(surface.name),
        link=member.named(surface.link),
        pose=_placed(surface.link, surface.pose, member),
    )


def _placed(link: str, pose: Pose, member: Member) -> Pose:
    """Return a pose on a link; what is fixed to a robot's world moves along with that world."""
    return compose(member.pose, pose) if link == WORLD else pose


def _point(link: str, position: Vector3, member: Member) -> Vector3:
    return apply(member.pose, position) if link == WORLD else position
