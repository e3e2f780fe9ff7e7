"""Reader of robots from any of their file formats."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ..checks.check import check
from ..errors import InputError, RobotError
from ..finding import Finding, Subject, errors_first
from ..finding_builders import warning
from ..mesh_files import lies_in
from ..model.robot import Robot
from .caspr.read import read_caspr
from .caspr.read_trajectories import (
    read_trajectories,
    read_trajectory,
    trajectories_file,
    trajectory_names,
)
from .kinds import ROBOT_PATHS, Kind, holds_robot, kind_of, robot_file
from .mjcf.read import read_mjcf
from .muscle_table.beside import table_of, with_table
from .opensim.read import read_osim
from .reading.equal_limits import lock_equal_limits
from .reading.unread import note_unread
from .reading.xml import ABSOLUTE, Notes, short_repr
from .sdf.read import read_sdf
from .urdf.read import read_urdf

__all__ = [
    "ABSOLUTE",
    "ROBOT_PATHS",
    "Reading",
    "holds_robot",
    "read",
    "read_robot",
    "read_trajectories",
    "read_trajectory",
    "trajectories_file",
    "trajectory_names",
]

IGNORED = frozenset({
    # OpenSim: appearance, texts, and values without influence in OpenSim; for default
    # activations there is the finding `start-left-out`
    "Appearance", "FrameGeometry", "credits", "default_activation", "defaults", "fixed",
    "force_units", "groups", "length_units", "method", "optimal_force", "prescribed_function",
    "publications", "socket_frame",
    # SDF: appearance, wind, and contacts, which an experiment's world defines
    "allow_auto_disable", "ambient", "cast_shadows", "emissive", "enable_wind", "laser_retro",
    "max_contacts", "self_collide", "specular", "surface", "transparency",
})  # fmt: skip
"""Tags of elements without influence on the robot and its motion."""

Reader = Callable[[Path, str | None, Notes], Robot | None]


@dataclass(frozen=True)
class Reading:
    """Robot read from files, with all findings.

    Attributes:
        robot: The robot; None if the files have errors that prevent building it.
        findings: Errors and then warnings about the files and the robot, with file and line.
        files: All files that define the robot.
    """

    robot: Robot | None
    findings: tuple[Finding, ...]
    files: tuple[Path, ...]

    def require(self) -> Robot:
        """Return the robot if it has no errors.

        Raises:
            RobotError: The robot has errors; the exception contains all findings.
        """
        if self.robot is None or any(finding.is_error for finding in self.findings):
            raise RobotError(self.findings, file=next(iter(self.files), None))
        return self.robot


def read(path: str | Path, cable_set: str | None = None, *, repair: bool = False) -> Reading:
    """Read a robot and return it with all findings.

    A muscle table next to the robot file replaces the muscles of the default cable set.

    Args:
        path: A model.sdf, .urdf, .osim, MJCF .xml, CASPR `<name>_bodies.xml`, or the folder of one.
        cable_set: Cable set to activate; the default of the file if None.
        repair: Whether to repair known defects of published files; each repair is reported.

    Raises:
        InputError: A file is missing or is not readable XML.
        UnknownNameError: The cable set does not exist.
    """
    file = robot_file(Path(path))
    notes = Notes()
    table = table_of(file)
    robot = _reader(file, repair)(file, cable_set if table is None else None, notes)
    if robot is not None:
        note_unread(notes, IGNORED)
    if robot is not None and table is not None:
        robot = with_table(robot, table, notes)
        robot = robot if cable_set is None else robot.with_cable_set(cable_set)
    findings = [
        *notes.findings,
        *_files_outside(file, notes.files, file.stem if robot is None else robot.name),
    ]
    if robot is not None:
        robot, locked = lock_equal_limits(robot)
        findings += _with_locations([*locked, *check(robot)], notes, file)
    if any(finding.is_error for finding in notes.findings):
        robot = None
    return Reading(robot, tuple(errors_first(findings)), tuple(dict.fromkeys(notes.files)))


def read_robot(path: str | Path, cable_set: str | None = None, *, repair: bool = False) -> Robot:
    """Read a robot that has no errors; see `addin_sdfusion.robot.read_robot`."""
    return read(path, cable_set, repair=repair).require()


def _files_outside(main: Path, files: Sequence[Path], name: str) -> Iterator[Finding]:
    """Report files outside the robot folder; an untrusted robot may refer to any file."""
    outside = [file for file in dict.fromkeys(files) if not lies_in(file, [main.parent])]
    if outside:
        named = Path(os.path.relpath(outside[0], main.parent)).as_posix()
        problem = (
            f"{len(outside)} of its files are outside its folder (links are followed), such "
            f"as {short_repr(named)}; written robots contain their content, but FMUs and results "
            "contain only files inside the folder of the experiment"
        )
        note = warning(Subject("robot", name), "files-outside", problem)
        yield replace(note, file=main)


def _with_locations(findings: list[Finding], notes: Notes, file: Path) -> list[Finding]:
    """Return findings with file and line, without consequences of reading errors."""
    unread = {finding.subject for finding in notes.findings if finding.is_error}
    placed = []
    for finding in findings:
        if finding.subject not in unread or finding.code.startswith("duplicate"):
            where, line = notes.locations.get(finding.subject, (file, None))
            placed.append(replace(finding, file=where, line=line))
    return placed


def _reader(file: Path, repair: bool) -> Reader:
    kind = kind_of(file)
    if kind is None:
        raise InputError(f"is not a robot; specify {ROBOT_PATHS}", file=file)
    return partial(read_sdf, repair=repair) if kind == "sdf" else _READERS[kind]


_READERS: dict[Kind, Reader] = {
    "caspr": read_caspr,
    "urdf": read_urdf,
    "osim": read_osim,
    "mjcf": read_mjcf,
}
