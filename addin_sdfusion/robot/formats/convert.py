"""Conversion of a robot to the files of any format, with findings on all that is lost."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from ..checks.check import require_valid
from ..errors import InputError, UnknownNameError
from ..finding import Finding, Subject, errors_first
from ..finding_builders import all_task_frames, warning
from ..model.robot import WORLD, Robot
from ..model.trajectory import Trajectory
from ..transforms.joint_chains import Names
from ..transforms.simplify import align_frames, merge_fixed_joints
from .capability import require_writable
from .cardsflow.capabilities import cardsflow_losses
from .cardsflow.write import write_cardsflow_xml
from .caspr.capabilities import caspr_losses
from .caspr.trajectory_losses import trajectory_losses
from .caspr.write import write_caspr
from .mjcf.capabilities import mjcf_losses
from .mjcf.write import write_mjcf
from .mjcf.write_meshes import opens_mesh
from .opensim.capabilities import osim_losses
from .opensim.write import write_osim
from .sdf.capabilities import sdf_losses
from .sdf.write import write_sdf
from .urdf.capabilities import urdf_losses
from .urdf.write import write_urdf
from .writing.carried_meshes import CarriedMeshes
from .writing.file_names import name_losses

_ROBOTS = ("_bodies.xml", ".sdf", ".urdf", ".osim")
"""Ends of names by which a folder is known to hold a robot."""


_OF_MODELS = ("sdf", "gazebo")
"""Formats whose files name meshes as those of models."""


class Format(NamedTuple):
    """A format that robots are written in.

    Attributes:
        name: Its name.
        losses: What of a robot it cannot hold.
        write: Writes the files; raises RobotError where `losses` has errors.
        prepare: Makes an equal robot that it can hold.
        with_meshes: The format with meshes that are carried; None if it holds none.
        is_named: Whether its files have the robot's name.
    """

    name: str
    losses: Callable[[Robot], list[Finding]]
    write: Callable[[Robot, Path], list[Path]]
    prepare: Callable[[Robot], Robot] = lambda robot: robot
    with_meshes: Callable[[Format, CarriedMeshes], Format] | None = None
    is_named: bool = True


def _with_files(format_: Format, meshes: CarriedMeshes) -> Format:
    """Return a format whose URIs mean files next to the robot's."""

    def prepare(robot: Robot) -> Robot:
        return meshes.applied(format_.prepare(robot), keeps_models=format_.name in _OF_MODELS)

    def losses(robot: Robot) -> list[Finding]:
        return [*format_.losses(robot), *meshes.losses(robot)]

    def write(robot: Robot, folder: Path) -> list[Path]:
        there = meshes.write(folder)  # first: a robot that is there has its meshes
        return [*format_.write(robot, folder), *there]

    return format_._replace(prepare=prepare, losses=losses, write=write)


def _mjcf_with_files(format_: Format, meshes: CarriedMeshes) -> Format:
    """MJCF with those meshes that MuJoCo opens."""
    files = meshes.opened(opens_mesh)
    named = format_._replace(
        losses=lambda robot: mjcf_losses(robot, files),
        write=lambda robot, folder: write_mjcf(robot, folder, meshes=files),
    )
    carried = {name: file for name, file in meshes.files.items() if name in files}
    return _with_files(named, replace(meshes, files=carried))


def _for_caspr(robot: Robot) -> Robot:
    """CASPR has neither fixed joints nor frames of their own."""
    return align_frames(merge_fixed_joints(robot))


def _for_sdf(robot: Robot) -> Robot:
    """SDF has no joint of a link's name: libsdformat, too, calls it `<name>_joint`."""
    links = {link.name for link in robot.links}
    names = Names([WORLD, *links, *(joint.name for joint in robot.joints)])
    joints = tuple(
        replace(joint, name=names.give(f"{joint.name}_joint")) if joint.name in links else joint
        for joint in robot.joints
    )
    return robot if joints == robot.joints else replace(robot, joints=joints)


def _renamed_joints(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Joints that have a link's name; their coordinates keep theirs."""
    names = {joint.child: joint.name for joint in prepared.joints}
    for joint in robot.joints:
        new = names.get(joint.child, joint.name)
        if new != joint.name:
            problem = f"a link has its name, which the format forbids; it is called {new!r} there"
            yield warning(Subject("joint", joint.name), "joint-renamed", problem)


def _merged_links(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Links that are no longer there, because fixed joints were merged."""
    left = {link.name for link in prepared.links}
    gone = [link.name for link in robot.links if link.name not in left]
    if gone:
        problem = (
            "the format has no fixed joints: links are merged into those they are fixed to, "
            "without their far ends, or into the world, which takes their points and neither mass "
            f"nor meshes: {', '.join(gone)}"
        )
        yield warning(Subject("robot", robot.name), "links-merged", problem)


def _turned_orientations(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Angles of a link whose frame was turned count from another zero."""
    turned = {
        joint.child
        for joint in robot.joints
        if any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy)
    }
    if prepared is robot or not turned:
        return
    for subject, frame in all_task_frames(robot):
        if frame.is_orientation:
            problem = (
                "link frames are turned parallel to the world at q = 0, where its angles are 0"
            )
            yield warning(subject, "orientation-from-zero-pose", problem)


_write_gazebo = partial(write_sdf, plugin=False)

FORMATS: dict[str, Format] = {
    format_.name: format_
    for format_ in (
        Format("sdf", sdf_losses, write_sdf, _for_sdf, _with_files, is_named=False),
        Format("gazebo", sdf_losses, _write_gazebo, with_meshes=_with_files, is_named=False),
        Format("caspr", caspr_losses, write_caspr, _for_caspr),
        Format("cardsflow", cardsflow_losses, write_cardsflow_xml, is_named=False),
        Format("urdf", urdf_losses, write_urdf, with_meshes=_with_files),
        Format("mjcf", mjcf_losses, write_mjcf, with_meshes=_mjcf_with_files),
        Format("osim", osim_losses, write_osim, with_meshes=_with_files),
    )
}


def format_of(
    name: str,
    trajectories: Sequence[Trajectory] = (),
    meshes: CarriedMeshes | None = None,
) -> Format:
    """A format by its name, ready to write a robot's trajectories, or to say that they are lost.

    Args:
        name: Its name.
        trajectories: The trajectories.
        meshes: Meshes to write next to the robot, where the format holds any.

    Raises:
        UnknownNameError: There is no such format.
    """
    if name not in FORMATS:
        raise UnknownNameError("format", name, FORMATS)
    format_ = FORMATS[name]
    if meshes is not None and format_.with_meshes is not None:
        format_ = format_.with_meshes(format_, meshes)
    if not trajectories:
        return format_
    if name == "caspr":
        return _caspr_with(trajectories)
    names = ", ".join(repr(trajectory.name) for trajectory in trajectories)

    def losses(robot: Robot) -> list[Finding]:
        problem = f"{name} has no trajectories; {len(trajectories)} left out: {names}"
        lost = warning(Subject("robot", robot.name), "trajectories-left-out", problem)
        return [*format_.losses(robot), lost]

    return format_._replace(losses=losses)


def _caspr_with(trajectories: Sequence[Trajectory]) -> Format:
    """CASPR with the trajectories that are ones of the robot."""

    def unfit(robot: Robot) -> list[Finding]:
        return [f for f in trajectory_losses(robot, trajectories) if f.is_error]

    def fitting(robot: Robot) -> list[Trajectory]:
        left_out = {finding.subject.name for finding in unfit(robot)}
        return [trajectory for trajectory in trajectories if trajectory.name not in left_out]

    def losses(robot: Robot) -> list[Finding]:
        lost = [
            replace(f, severity="warning", message=f"{f.message}; left out") for f in unfit(robot)
        ]
        return [*caspr_losses(robot, fitting(robot)), *lost]

    def write(robot: Robot, folder: Path) -> list[Path]:
        return write_caspr(robot, folder, trajectories=fitting(robot))

    return FORMATS["caspr"]._replace(losses=losses, write=write)


class Conversion(NamedTuple):
    """What a conversion gave.

    Attributes:
        files: The files written.
        findings: What the format cannot hold.
    """

    files: list[Path]
    findings: list[Finding]


def convert(
    robot: Robot,
    format_: str,
    folder: str | Path,
    trajectories: Sequence[Trajectory] = (),
    *,
    mesh_folder: Path | None = None,
    sources: Sequence[Path] = (),
) -> Conversion:
    """Write a robot in another format.

    Args:
        robot: The robot; its active cable set and operational space count most.
        format_: One of `FORMATS`.
        folder: Where to; made if it does not exist.
        trajectories: The robot's; of all formats CASPR has them.
        mesh_folder: The folder of the robot's file: meshes in it are written too. None leaves them.
        sources: Files that the robot was read from; none is replaced.

    Raises:
        UnknownNameError: There is no such format.
        RobotError: The robot has errors, or the format cannot hold it at all.
        InputError: The folder cannot be written, or a source would be replaced.
    """
    meshes = None if mesh_folder is None else CarriedMeshes.of(robot, mesh_folder)
    chosen = format_of(format_, trajectories, meshes)
    own = {file.resolve() for file in sources}
    if any(file.parent == Path(folder).resolve() for file in own):
        with tempfile.TemporaryDirectory() as aside:
            files = convert_to(chosen, robot, aside).files
            places = [Path(folder) / file.relative_to(aside) for file in files]
        taken = next((place for place in places if place.resolve() in own), None)
        if taken is not None:
            what = "is an input of the conversion and is not overwritten; choose another folder"
            raise InputError(what, file=taken)
    return convert_to(chosen, robot, folder)


def convert_to(format_: Format, robot: Robot, folder: str | Path) -> Conversion:
    """As `convert`, in a format that need not be one of `FORMATS`.

    Raises:
        RobotError: The robot has errors, or the format cannot hold it at all.
        InputError: The folder cannot be written.
    """
    findings = losses_in(format_, robot)
    require_writable(findings, format_.name)
    files = format_.write(format_.prepare(robot), Path(folder))
    return Conversion(files, [*findings, *_beside_others(robot, Path(folder), files)])


def _beside_others(robot: Robot, folder: Path, files: Sequence[Path]) -> Iterator[Finding]:
    """Other robots in the folder, which its name may now mean."""
    written = {file.name for file in files}
    there = sorted(file.name for ending in _ROBOTS for file in folder.glob(f"*{ending}"))
    others = [name for name in there if name not in written]
    if others:
        problem = (
            f"the folder holds {', '.join(others[:5])}{', ...' if len(others) > 5 else ''} too: "
            "name the file, not the folder, where this robot is meant"
        )
        yield warning(Subject("robot", robot.name), "beside-other-robots", problem)


def losses_in(format_: Format, robot: Robot) -> list[Finding]:
    """Everything that a format cannot hold of a robot, and what is done about it.

    Returns:
        Errors, for which it is not written, then warnings.

    Raises:
        RobotError: The robot itself has errors.
    """
    require_valid(robot)
    prepared = format_.prepare(robot)
    return errors_first(
        [
            *_merged_links(robot, prepared),
            *_renamed_joints(robot, prepared),
            *_turned_orientations(robot, prepared),
            *(name_losses(robot) if format_.is_named else ()),
            *format_.losses(prepared),
        ]
    )
