"""First experiment for a robot, with a test run before it is written."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from addin_sdfusion.robot import Finding, InputError, Robot
from addin_sdfusion.robot.checks.not_simulated import NOT_SIMULATED
from addin_sdfusion.robot.checks.plausible import plausible
from addin_sdfusion.robot.files import file_error, is_folder, write_files
from addin_sdfusion.robot.formats.read import read
from addin_sdfusion.robot.mesh_files import lies_in
from cardsflow_fmu.experiment.packed_files import mesh_roots
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.settings.robots import require_movable
from cardsflow_fmu.experiment.template import experiment_text
from cardsflow_fmu.results.analysis.first_motion import initial_pose
from cardsflow_fmu.results.analysis.moment_arms import sign_changes
from sim_dart import control_dynamics

from .draft_search import DraftSearch, TestRun

_NOTED = ("no-force-limit", "initial-outside-limits", *NOT_SIMULATED)
"""Codes of findings that are included in the notes of the experiment."""


@dataclass(frozen=True)
class FirstExperiment:
    """Text of an experiment, with the test run that checked it.

    Attributes:
        text: Text of the experiment.toml.
        notes: Changes that make the robot movable, one line each.
        test_run: Result of the test run; None if the native models do not support the robot.
    """

    text: str
    notes: tuple[str, ...]
    test_run: TestRun | None


@dataclass(frozen=True)
class Starter:
    """First experiment of a robot."""

    file: Path
    notes: tuple[str, ...]
    findings: tuple[Finding, ...]
    test_run: TestRun | None


def init(
    robot: str | Path,
    output: str | Path = EXPERIMENT_TOML,
    cable_set: str | None = None,
    *,
    overwrite: bool = False,
) -> Starter:
    """Write an experiment.toml for a robot that `cardsflow run` can run without changes.

    Args:
        robot: Robot file (.sdf, .urdf, .osim, MJCF .xml, *_bodies.xml) or its folder.
        output: The file, or the folder of experiment.toml.
        cable_set: Name of the cable set (default: as in the robot file).
        overwrite: Whether to replace an existing file.

    Returns:
        The file, notes, findings, and the test run.

    Raises:
        InputError: The file exists or cannot be written, or the muscles cannot move the robot.
        RobotError: The robot is invalid.
    """
    file = Path(output)
    if is_folder(file) or not file.suffix:
        file /= EXPERIMENT_TOML
    if file.suffix != ".toml":
        raise InputError("must have the suffix .toml", file=file, key="-o")
    if not overwrite:
        _require_new(file)
    movable, findings = read_movable(robot, cable_set, file.parent)
    path = path_from(file.parent, Path(robot))
    first = find_experiment(movable, Path(robot), path, cable_set)
    dynamics = control_dynamics(movable, may_be_singular=True)
    findings += tuple(sign_changes(movable, dynamics, initial_pose(movable)))
    if overwrite:
        write_files(file.parent, {file.name: first.text})
    else:
        _write_new(file, first.text)
    return Starter(file, first.notes, findings, first.test_run)


def find_experiment(
    robot: Robot, files: Path, path: str, cable_set: str | None = None
) -> FirstExperiment:
    """Return an experiment for a robot whose test run tracks the reference, or the best one.

    Args:
        files: Robot file or its folder.
        path: Path of the robot in the text, relative to the folder of the experiment.
        cable_set: Name of the cable set; None for the default of the robot file.

    Raises:
        InputError: The muscles cannot move the robot.
    """
    try:
        draft, test_run = DraftSearch(robot, files, cable_set).find_best()
    except InputError as error:
        error.file = error.file or files
        if (cause := next(plausible(robot), None)) is not None:
            error.problem += f"; possible cause: {cause.message}"
        raise
    return FirstExperiment(experiment_text(robot, path, draft, cable_set), draft.notes, test_run)


def read_movable(
    robot: str | Path, cable_set: str | None, folder: Path
) -> tuple[Robot, tuple[Finding, ...]]:
    """Read a robot that has movable joints and drives, and its findings.

    Raises:
        InputError: The robot cannot be read, has no movable joints or no drives, or has files
            that a run in this folder does not open.
        RobotError: The robot is invalid.
    """
    reading = read(robot, cable_set)
    movable = reading.require()
    try:
        require_movable(movable, reading)
    except InputError as error:
        error.file = Path(robot)
        raise
    _require_inside(reading.files, folder)
    return movable, tuple(f for f in reading.findings if f.code not in _NOTED)


def _require_inside(files: Sequence[Path], folder: Path) -> None:
    """Check that a run opens all files: those in the folder of the robot or of the experiment."""
    main = files[0]
    outside = [file for file in files if not lies_in(file, mesh_roots(folder / "_", [main], ()))]
    if outside:
        common = os.path.commonpath([file.resolve() for file in files])
        parent = os.path.relpath(common)
        problem = (
            f"is outside the folders of robot and experiment, and a run does not open it; write "
            f"the experiment to a folder that contains all files: -o {parent}"
        )
        raise InputError(problem, file=outside[0])


def path_from(folder: Path, robot: Path) -> str:
    """Return the path of the robot relative to a folder; absolute on another drive."""
    try:
        return Path(os.path.relpath(robot.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return robot.resolve().as_posix()


def _require_new(file: Path) -> None:
    if os.path.lexists(file):
        problem = "already exists; choose another file with -o, or use --overwrite"
        raise InputError(problem, file=file)


def _write_new(file: Path, text: str) -> None:
    """Write a new file; a failed write leaves no file."""
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
