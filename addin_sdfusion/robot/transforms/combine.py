"""Combination of several robots in one world; part names get the robot's name as a prefix."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import InputError
from ..mesh_files import mesh_file
from ..model.joint import Joint, rename_coordinate
from ..model.loop import LoopJoint
from ..model.muscle import BasePulley, CableSet, Muscle, ViaPoint, Wrap, WrapSurface
from ..model.muscle_path import PointMotion
from ..model.pose import IDENTITY, Pose, Vector3
from ..model.robot import WORLD, Link, Robot, TaskFrame, TaskSet
from ..model.rotations import apply, compose, rotate, rotation

_DIRECTIONS = ("cable_entry_vector", "winch_vector", "cable_pulley_entry_vector")
"""Parameters of pulleys that are directions."""


@dataclass(frozen=True)
class Member:
    """One of several robots that are combined.

    Attributes:
        name: Name of the robot; its parts are renamed to `<name>_<part>`.
        pose: Pose of the robot's world in the common world.
        folder: Folder of the mesh files, or None to keep the URIs unchanged.
        roots: Further folders and files that can contain meshes, see `mesh_files.lies_in`.
    """

    name: str
    robot: Robot
    pose: Pose = IDENTITY
    folder: Path | None = None
    roots: tuple[Path, ...] = ()

    def full_name(self, item: str) -> str:
        """Return the name of a part in the combined robot."""
        return item if item == WORLD else f"{self.name}_{item}"


def combine(name: str, members: Sequence[Member]) -> Robot:
    """Combine several robots into one.

    Its coordinates, muscles and task coordinates are those of the members' active sets, in the
    order of the members.

    Raises:
        InputError: There are no members, names are not unique, or gravity differs.
    """
    if not members:
        raise InputError("no robots to combine; name at least one")
    _require_unique("robots", [member.name for member in members])
    gravities = {member.robot.gravity for member in members}
    if len(gravities) > 1:
        listed = ", ".join(f"{member.name} {member.robot.gravity}" for member in members)
        raise InputError(f"the robots have different gravity ({listed}); set the same for all")
    links = tuple(_link(link, member) for member in members for link in member.robot.links)
    joints = tuple(_joint(joint, member) for member in members for joint in member.robot.joints)
    muscles = tuple(_muscle(m, member) for member in members for m in member.robot.muscles)
    frames = tuple(_frame(f, member) for member in members for f in member.robot.task_frames)
    surfaces = tuple(_surface(s, member) for member in members for s in member.robot.wrap_surfaces)
    loops = tuple(_loop(loop, member) for member in members for loop in member.robot.loops)
    _require_unique("links", [link.name for link in links])
    _require_unique("joints", [*(joint.name for joint in joints), *(loop.name for loop in loops)])
    _require_unique("coordinates", [c.name for joint in joints for c in joint.coordinates])
    _require_unique("muscles", [muscle.name for muscle in muscles])
    _require_unique("task frames", [frame.name for frame in frames])
    _require_unique("wrap surfaces", [surface.name for surface in surfaces])
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


def _require_unique(kind: str, names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise InputError(f"two {kind} would have the name {name!r}; rename a robot")
        seen.add(name)


def _link(link: Link, member: Member) -> Link:
    meshes = link.meshes
    if member.folder is not None:
        folder = member.folder.resolve()
        files = [mesh_file(mesh.uri, folder, (folder, *member.roots)) for mesh in meshes]
        meshes = tuple(
            replace(mesh, uri=str(file)) for mesh, file in zip(meshes, files, strict=True)
        )
    return replace(link, name=member.full_name(link.name), meshes=meshes)


def _joint(joint: Joint, member: Member) -> Joint:
    return replace(
        joint,
        name=member.full_name(joint.name),
        parent=member.full_name(joint.parent),
        child=member.full_name(joint.child),
        coordinates=tuple(rename_coordinate(c, member.full_name) for c in joint.coordinates),
        T_parent_joint=_moved_pose(joint.parent, joint.T_parent_joint, member),
    )


def _loop(loop: LoopJoint, member: Member) -> LoopJoint:
    return replace(
        loop,
        name=member.full_name(loop.name),
        parent=member.full_name(loop.parent),
        child=member.full_name(loop.child),
        T_parent_joint=_moved_pose(loop.parent, loop.T_parent_joint, member),
        T_child_joint=_moved_pose(loop.child, loop.T_child_joint, member),
    )


def _muscle(muscle: Muscle, member: Member) -> Muscle:
    points = tuple(_via_point(point, member) for point in muscle.via_points)
    wraps = tuple(_wrap(wrap, member) for wrap in muscle.wraps)
    terms = tuple(replace(t, coordinate=member.full_name(t.coordinate)) for t in muscle.terms)
    pulley = muscle.pulley
    if pulley is not None and muscle.via_points[0].link == WORLD:
        pulley = _turned(pulley, member)
    name = member.full_name(muscle.name)
    path = {"via_points": points, "wraps": wraps, "terms": terms}
    return replace(muscle, name=name, pulley=pulley, **path)  # type: ignore[arg-type]


def _via_point(point: ViaPoint, member: Member) -> ViaPoint:
    when = point.when
    return replace(
        point,
        link=member.full_name(point.link),
        position=_point(point.link, point.position, member),
        when=when and replace(when, coordinate=member.full_name(when.coordinate)),
        moves=tuple(_point_motion(point.link, move, member) for move in point.moves),
    )


def _point_motion(link: str, move: PointMotion, member: Member) -> PointMotion:
    R = rotation(member.pose.rpy)
    axis = rotate(R, move.axis) if link == WORLD else move.axis
    return replace(move, axis=axis, coordinate=member.full_name(move.coordinate))


def _wrap(wrap: Wrap, member: Member) -> Wrap:
    side = wrap.side_point
    named = member.full_name(wrap.surface)
    return replace(wrap, surface=named, side_point=side and _via_point(side, member))


def _turned(pulley: BasePulley, member: Member) -> BasePulley:
    """Return a pulley on a robot's world, with directions rotated like that world."""
    R = rotation(member.pose.rpy)
    parameters = tuple(
        (key, rotate(R, (values[0], values[1], values[2])) if key in _DIRECTIONS else values)
        for key, values in pulley.parameters
    )
    return replace(pulley, parameters=parameters)


def _frame(frame: TaskFrame, member: Member) -> TaskFrame:
    return replace(
        frame,
        name=member.full_name(frame.name),
        link=member.full_name(frame.link),
        position=_point(frame.link, frame.position, member),
    )


def _surface(surface: WrapSurface, member: Member) -> WrapSurface:
    return replace(
        surface,
        name=member.full_name(surface.name),
        link=member.full_name(surface.link),
        pose=_moved_pose(surface.link, surface.pose, member),
    )


def _moved_pose(link: str, pose: Pose, member: Member) -> Pose:
    """Return a pose on a link; poses on a robot's world are moved with that world."""
    return compose(member.pose, pose) if link == WORLD else pose


def _point(link: str, position: Vector3, member: Member) -> Vector3:
    return apply(member.pose, position) if link == WORLD else position
