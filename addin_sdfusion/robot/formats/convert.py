"""Conversion of a robot to any format, with findings on all information that is lost."""

from __future__ import annotations

import filecmp
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from ..checks.check import require_valid
from ..errors import InputError, UnknownNameError
from ..files import file_error
from ..finding import Finding, Subject, errors_first
from ..finding_builders import all_task_frames, warning
from ..model.robot import WORLD, Robot
from ..model.trajectory import Trajectory
from ..transforms.joint_chains import Names
from ..transforms.simplify import align_frames, merge_fixed_joints
from .capability import require_writable
from .cardsflow.capabilities import CARDSFLOW
from .cardsflow.write import write_cardsflow_xml
from .caspr.capabilities import caspr_losses
from .caspr.trajectory_losses import trajectory_losses
from .caspr.write import write_caspr
from .mjcf.capabilities import mjcf_losses
from .mjcf.write import write_mjcf
from .mjcf.write_meshes import can_open_mesh
from .muscle_table.beside import MUSCLES_CSV, table_losses, table_of, write_table
from .opensim.capabilities import osim_losses
from .opensim.write import write_osim
from .sdf.capabilities import sdf_losses
from .sdf.write import write_sdf
from .urdf.capabilities import URDF
from .urdf.write import write_urdf
from .writing.carried_meshes import CarriedMeshes
from .writing.file_names import file_name_findings

_ROBOT_ENDINGS = ("_bodies.xml", ".sdf", ".urdf", ".osim")
"""File name endings that identify a folder as a robot folder."""


_MODEL_FORMATS = ("sdf", "gazebo")
"""Formats whose mesh URIs refer to models (`model://`)."""


_WITHOUT_LINKS = ("cardsflow", MUSCLES_CSV)
"""Formats for files that belong next to a robot file."""


class Format(NamedTuple):
    """File format that robots can be written in.

    Attributes:
        losses: Function that returns findings on everything that the format cannot hold.
        write: Function that writes the files; raises RobotError if `losses` returns errors.
        prepare: Function that returns an equivalent robot that the format can hold.
        with_meshes: Function that returns the format with copied meshes; None if not supported.
        is_named: Whether the file names contain the name of the robot.
    """

    name: str
    losses: Callable[[Robot], list[Finding]]
    write: Callable[[Robot, Path], list[Path]]
    prepare: Callable[[Robot], Robot] = lambda robot: robot
    with_meshes: Callable[[Format, CarriedMeshes], Format] | None = None
    is_named: bool = True


def _with_files(format_: Format, meshes: CarriedMeshes) -> Format:
    """Return the format with mesh URIs that refer to files next to the robot file."""

    def prepare(robot: Robot) -> Robot:
        return meshes.apply_to(format_.prepare(robot), keeps_models=format_.name in _MODEL_FORMATS)

    def losses(robot: Robot) -> list[Finding]:
        return [*format_.losses(robot), *meshes.losses(robot)]

    def write(robot: Robot, folder: Path) -> list[Path]:
        written = meshes.write(folder)  # first, so that a written robot has its meshes
        return [*format_.write(robot, folder), *written]

    return format_._replace(prepare=prepare, losses=losses, write=write)


def _mjcf_with_files(format_: Format, meshes: CarriedMeshes) -> Format:
    """Return MJCF with the meshes that MuJoCo can open."""
    files = meshes.readable_by(can_open_mesh)
    named = format_._replace(
        losses=lambda robot: mjcf_losses(robot, files),
        write=lambda robot, folder: write_mjcf(robot, folder, meshes=files),
    )
    carried = {name: file for name, file in meshes.files.items() if name in files}
    return _with_files(named, replace(meshes, files=carried))


def _for_caspr(robot: Robot) -> Robot:
    """Return the robot without fixed joints and rotated frames, which CASPR does not support."""
    return align_frames(merge_fixed_joints(robot))


def _for_sdf(robot: Robot) -> Robot:
    """Return the robot without joints that have the name of a link, which SDF does not allow.

    A renamed joint is called `<name>_joint`, as in libsdformat.
    """
    links = {link.name for link in robot.links}
    names = Names([WORLD, *links, *(joint.name for joint in robot.joints)])
    joints = tuple(
        replace(joint, name=names.unique(f"{joint.name}_joint")) if joint.name in links else joint
        for joint in robot.joints
    )
    return robot if joints == robot.joints else replace(robot, joints=joints)


def _renamed_joints(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Report joints that were renamed because a link has the same name."""
    names = {joint.child: joint.name for joint in prepared.joints}
    for joint in robot.joints:
        new = names.get(joint.child, joint.name)
        if new != joint.name:
            problem = f"the format forbids joints with the name of a link; renamed to {new!r}"
            yield warning(Subject("joint", joint.name), "joint-renamed", problem)


def _merged_links(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Report links that were merged because the format has no fixed joints."""
    written = {link.name for link in prepared.links}
    merged = [link.name for link in robot.links if link.name not in written]
    if merged:
        problem = (
            "the format has no fixed joints: links are merged into the link they are fixed to, "
            "without their far ends; a link fixed to the world loses its mass and meshes: "
            f"{', '.join(merged)}"
        )
        yield warning(Subject("robot", robot.name), "links-merged", problem)


def _turned_orientations(robot: Robot, prepared: Robot) -> Iterator[Finding]:
    """Report orientations whose zero changed because a link frame was rotated."""
    turned = {
        joint.child
        for joint in robot.joints
        if any(joint.T_parent_joint.rpy) or any(joint.T_child_joint.rpy)
    }
    if prepared is robot or not turned:
        return
    for subject, frame in all_task_frames(robot):
        if frame.is_orientation:
            problem = "link frames are aligned with the world at q = 0, where its angles are 0"
            yield warning(subject, "orientation-from-zero-pose", problem)


_write_gazebo = partial(write_sdf, plugin=False)

FORMATS: dict[str, Format] = {
    format_.name: format_
    for format_ in (
        Format("sdf", sdf_losses, write_sdf, _for_sdf, _with_files, is_named=False),
        Format("gazebo", sdf_losses, _write_gazebo, with_meshes=_with_files, is_named=False),
        Format("caspr", caspr_losses, write_caspr, _for_caspr),
        Format("cardsflow", CARDSFLOW.losses, write_cardsflow_xml, is_named=False),
        Format("urdf", URDF.losses, write_urdf, with_meshes=_with_files),
        Format("mjcf", mjcf_losses, write_mjcf, with_meshes=_mjcf_with_files),
        Format("osim", osim_losses, write_osim, with_meshes=_with_files),
        Format(MUSCLES_CSV, table_losses, write_table, is_named=False),
    )
}


def format_of(
    name: str,
    trajectories: Sequence[Trajectory] = (),
    meshes: CarriedMeshes | None = None,
) -> Format:
    """Return a format by its name, which also writes trajectories or reports their loss.

    Args:
        meshes: Meshes to write next to the robot if the format supports meshes.

    Raises:
        UnknownNameError: The format does not exist.
    """
    if name not in FORMATS:
        raise UnknownNameError("format", name, FORMATS)
    format_ = FORMATS[name]
    if meshes is not None and format_.with_meshes is not None:
        format_ = format_.with_meshes(format_, meshes)
    if not trajectories:
        return format_
    if name == "caspr":
        return _caspr_with_trajectories(trajectories)
    names = ", ".join(repr(trajectory.name) for trajectory in trajectories)

    def losses(robot: Robot) -> list[Finding]:
        problem = f"{name} has no trajectories; {len(trajectories)} omitted: {names}"
        lost = warning(Subject("robot", robot.name), "trajectories-left-out", problem)
        return [*format_.losses(robot), lost]

    return format_._replace(losses=losses)


def _caspr_with_trajectories(trajectories: Sequence[Trajectory]) -> Format:
    """Return CASPR with those trajectories that match the robot."""

    def mismatches(robot: Robot) -> list[Finding]:
        return [f for f in trajectory_losses(robot, trajectories) if f.is_error]

    def matching(robot: Robot) -> list[Trajectory]:
        left_out = {finding.subject.name for finding in mismatches(robot)}
        return [trajectory for trajectory in trajectories if trajectory.name not in left_out]

    def losses(robot: Robot) -> list[Finding]:
        lost = [
            replace(f, severity="warning", message=f"{f.message}; omitted")
            for f in mismatches(robot)
        ]
        return [*caspr_losses(robot, matching(robot)), *lost]

    def write(robot: Robot, folder: Path) -> list[Path]:
        return write_caspr(robot, folder, trajectories=matching(robot))

    return FORMATS["caspr"]._replace(losses=losses, write=write)


class Conversion(NamedTuple):
    """Result of a conversion."""

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
    overwrite: bool = False,
) -> Conversion:
    """Write a robot in another format.

    Args:
        robot: The robot. Most formats hold only its active cable set and operational space.
        format_: One of `FORMATS`.
        folder: Output folder; created if it does not exist.
        trajectories: Trajectories of the robot; only CASPR files can hold them.
        mesh_folder: Folder of the robot file; meshes in it are copied. None copies no meshes.
        sources: Files that the robot was read from; they are never overwritten.
        overwrite: Whether to replace existing files that have other contents.

    Raises:
        UnknownNameError: The format does not exist.
        RobotError: The robot has errors, or the format cannot hold it.
        InputError: The folder cannot be written, a source would be overwritten, or an existing file
            has other contents.
    """
    meshes = None if mesh_folder is None else CarriedMeshes.of(robot, mesh_folder)
    chosen = format_of(format_, trajectories, meshes)
    if Path(folder).is_dir() and any(Path(folder).iterdir()):
        _require_free_places(chosen, robot, Path(folder), sources, overwrite=overwrite)
    return convert_to(chosen, robot, folder)


def _require_free_places(
    format_: Format, robot: Robot, folder: Path, sources: Sequence[Path], *, overwrite: bool
) -> None:
    """Reject a conversion that would overwrite a source or a file with other contents."""
    inputs = {file.resolve() for file in sources}
    with tempfile.TemporaryDirectory() as aside:
        for file in convert_to(format_, robot, aside).files:
            place = folder / file.relative_to(aside)
            if place.resolve() in inputs:
                problem = (
                    "is an input of the conversion and is not overwritten; choose another folder"
                )
                raise InputError(problem, file=place)
            if not overwrite and place.exists() and not _have_equal_contents(place, file):
                problem = (
                    "already exists with other contents; choose another folder or use --overwrite"
                )
                raise InputError(problem, file=place)


def _have_equal_contents(first: Path, second: Path) -> bool:
    """Return whether two files have equal contents."""
    try:
        return first.is_file() and filecmp.cmp(first, second, shallow=False)
    except OSError as error:
        raise file_error(error, "cannot be read", first) from None


def convert_to(format_: Format, robot: Robot, folder: str | Path) -> Conversion:
    """Write a robot in a format that need not be one of `FORMATS`; see `convert`.

    Raises:
        RobotError: The robot has errors, or the format cannot hold it.
        InputError: The folder cannot be written.
    """
    findings = losses_in(format_, robot)
    require_writable(findings, format_.name)
    files = format_.write(format_.prepare(robot), Path(folder))
    if format_.name not in _WITHOUT_LINKS:
        findings += _other_files(robot, Path(folder), files)
    return Conversion(files, findings)


def _other_files(robot: Robot, folder: Path, files: Sequence[Path]) -> Iterator[Finding]:
    """Report files in the folder that change how the written robot is read.

    These are other robot files, which make the folder name ambiguous, and a muscle table.
    """
    written, subject = {file.name for file in files}, Subject("robot", robot.name)
    names = sorted(file.name for ending in _ROBOT_ENDINGS for file in folder.glob(f"*{ending}"))
    others = [name for name in names if name not in written]
    if others:
        problem = (
            f"the folder also has {', '.join(others[:5])}{', ...' if len(others) > 5 else ''}; "
            "specify the file instead of the folder to read this robot"
        )
        yield warning(subject, "beside-other-robots", problem)
    table = table_of(files[0]) if files else None
    if table is not None:
        problem = f"{table.name} in the folder replaces the muscles of the written robot; move it"
        yield warning(subject, "beside-muscle-table", problem)


def losses_in(format_: Format, robot: Robot) -> list[Finding]:
    """Return findings on everything of a robot that a format cannot hold.

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
            *(file_name_findings(robot) if format_.is_named else ()),
            *format_.losses(prepared),
        ]
    )
