"""A first experiment for a robot, tried before it is written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from addin_sdfusion.robot import Finding, InputError, Robot
from addin_sdfusion.robot.checks.not_simulated import NOT_SIMULATED
from addin_sdfusion.robot.files import file_error, is_folder, write_files
from addin_sdfusion.robot.formats.read import read
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.template import experiment_text

from .trials import Search, Trial

_REMARKED = ("no-force-limit", "initial-outside-limits", *NOT_SIMULATED)
"""Findings that are remarks of an experiment."""


@dataclass(frozen=True)
class Starter:
    """A first experiment.

    Attributes:
        file: Where it is.
        notes: What was changed or left out so that the robot moves, a line each.
        findings: What is doubtful in the robot's files.
        trial: What a run of it gave; None where it was not tried.
    """

    file: Path
    notes: tuple[str, ...]
    findings: tuple[Finding, ...]
    trial: Trial | None


def init(
    robot: str | Path,
    output: str | Path = EXPERIMENT_TOML,
    cable_set: str | None = None,
    *,
    overwrite: bool = False,
) -> Starter:
    """Write an experiment.toml for a robot, which `cardsflow run` runs as it is.

    Args:
        robot: A robot's file (.sdf, .urdf, .osim, MJCF .xml, *_bodies.xml) or its folder.
        output: The file, or a folder for experiment.toml.
        cable_set: The cable set to use; the file's own when None.
        overwrite: Whether to replace an existing file.

    Returns:
        The file, and what there is to know of it.

    Raises:
        InputError: The file is there already or cannot be written, or the robot cannot be moved.
        RobotError: The robot cannot be used.
    """
    file = Path(output)
    if is_folder(file) or not file.suffix:
        file /= EXPERIMENT_TOML
    if file.suffix != ".toml":
        raise InputError("an experiment is a .toml", file=file, key="-o")
    if not overwrite:
        _require_new(file)
    found, findings = read_movable(robot, cable_set)
    path = path_from(file.parent, Path(robot))
    try:
        beginning, trial = Search(found, Path(robot), cable_set).best()
    except InputError as error:
        error.file = error.file or Path(robot)
        raise
    text = experiment_text(found, path, beginning, cable_set)
    if overwrite:
        write_files(file.parent, {file.name: text})
    else:
        _write_new(file, text)
    return Starter(file, beginning.remarks, findings, trial)


def read_movable(
    robot: str | Path, cable_set: str | None = None
) -> tuple[Robot, tuple[Finding, ...]]:
    """A robot that something can move, and what is doubtful in its files.

    Raises:
        InputError: It cannot be read, or nothing moves.
        RobotError: It cannot be used.
    """
    reading = read(robot, cable_set)
    found = reading.require()
    if not (found.coordinates and (found.muscles or found.motors)):
        lack = "no muscles and no motors" if found.coordinates else "no joints that move"
        raise InputError(f"robot {found.name!r} has {lack}: there is nothing to run", file=robot)
    return found, tuple(f for f in reading.findings if f.code not in _REMARKED)


def path_from(folder: Path, robot: Path) -> str:
    """The way from the experiment's folder to the robot; the whole path on another drive."""
    try:
        return Path(os.path.relpath(robot.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return robot.resolve().as_posix()


def _require_new(file: Path) -> None:
    if os.path.lexists(file):
        what = "already exists; choose another file with -o, or use --overwrite"
        raise InputError(what, file=file)


def _write_new(file: Path, text: str) -> None:
    """Write a file that is not there, or nothing."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8") as stream:
            try:
                stream.write(text)
                stream.flush()
            except OSError:
                file.unlink()
                raise
    except (OSError, ValueError) as error:
        if isinstance(error, FileExistsError):
            _require_new(file)
        raise file_error(error, "cannot be written", file) from None
