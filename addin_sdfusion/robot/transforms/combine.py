"""Combination of several robots in one world; part names get the robot's name as a prefix."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..mesh_files import mesh_file
from ..model.muscle import CableSet
from ..model.pose import IDENTITY, Pose
from ..model.robot import WORLD, Robot, TaskSet
from .part_map import PartMap


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

    def renamed(self) -> Robot:
        """Return the robot with full names, in the common world."""
        named, poses = self.full_name, {WORLD: self.pose}
        return PartMap(
            *(named,) * 6, self._mesh_uri, lambda link: poses.get(link, IDENTITY)
        ).apply_to(self.robot)

    def _mesh_uri(self, uri: str) -> str:
        if self.folder is None:
            return uri
        folder = self.folder.resolve()
        return str(mesh_file(uri, folder, (folder, *self.roots)))


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
    robots = [member.renamed() for member in members]
    links = tuple(link for robot in robots for link in robot.links)
    joints = tuple(joint for robot in robots for joint in robot.joints)
    muscles = tuple(muscle for robot in robots for muscle in robot.muscles)
    frames = tuple(frame for robot in robots for frame in robot.task_frames)
    surfaces = tuple(surface for robot in robots for surface in robot.wrap_surfaces)
    loops = tuple(loop for robot in robots for loop in robot.loops)
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
