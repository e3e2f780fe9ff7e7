"""Import of a CAD design as a robot folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import CardsflowError, Finding, InputError, Subject
from addin_sdfusion.robot.finding_builders import warning
from addin_sdfusion.robot.records import from_plain, to_plain
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot
from cardsflow_fmu.simulation.draft_search import TestRun
from cardsflow_fmu.simulation.starter import FirstExperiment, find_experiment, read_movable

from .script import script_design
from .step_design import Tables
from .step_process import TIME_LIMIT, design_of_step

STEP = (".step", ".stp")
"""Suffixes of STEP files."""

_MODEL = "model.sdf"


@dataclass(frozen=True)
class Imported:
    """Robot folder of a design.

    Attributes:
        files: The written files, in order.
        findings: Warnings, data that a format does not support, and files that were kept.
        losses: The findings on data that a format does not support, by the setting of the format.
        notes: Notes of the experiment on the robot, one line each; see `cardsflow init`.
        test_run: Test run of the experiment; None if there is no experiment or no test run.
    """

    files: tuple[Path, ...]
    findings: tuple[Finding, ...]
    losses: Mapping[str, tuple[Finding, ...]]
    notes: tuple[str, ...] = ()
    test_run: TestRun | None = None


def import_cad(
    file: str | Path,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    tables: Tables | None = None,
    time_limit: float = TIME_LIMIT,
) -> Imported:
    """Write the robot folder of a design, with an experiment that a test run has checked.

    Args:
        file: A snapshot (.json), a build123d program (.py), which is executed, or a STEP file
            (.step, .stp).
        folder: Output folder; created if it does not exist.
        settings: Changes to the settings of the design, see ExportSettings.
        tables: Tables with the information that a STEP file does not contain.
        time_limit: Time limit of the geometry kernel for a STEP file, in [s].

    Raises:
        RobotError: The design has errors. The exception contains all findings.
        InputError: The design cannot be read, a setting is invalid, or the folder cannot be
            written.
    """
    experiments: list[FirstExperiment] = []

    def experiment(robot: Path) -> tuple[str, list[Finding]]:
        try:
            experiments.append(_first_experiment(robot))
        except CardsflowError as error:
            return "", [_no_experiment(robot, error)]
        return experiments[0].text, []

    snapshot = read_design(file, settings, tables, time_limit)
    done = export_robot(snapshot, folder, experiment=experiment)
    notes, test_run = (experiments[0].notes, experiments[0].test_run) if experiments else ((), None)
    return Imported(done.files, done.findings, done.losses, notes, test_run)


def _first_experiment(folder: Path) -> FirstExperiment:
    robot, _ = read_movable(folder / _MODEL, None, folder)
    return find_experiment(robot, folder / _MODEL, _MODEL)


def _no_experiment(folder: Path, error: CardsflowError) -> Finding:
    """Return the warning that a robot has no experiment; the folder will be renamed."""
    reason = error.problem if isinstance(error, InputError) else str(error)
    problem = f"it is not written: {reason}".replace(f"{folder}{os.sep}", "")
    return warning(Subject("file", "experiment.toml"), "no-experiment", problem)


def read_design(
    file: str | Path,
    settings: Mapping[str, Any] | None = None,
    tables: Tables | None = None,
    time_limit: float = TIME_LIMIT,
) -> DesignSnapshot:
    """Return the snapshot of a design; arguments and errors as for `import_cad`."""
    file = Path(file)
    suffix = file.suffix.lower()
    if tables is not None and suffix not in STEP:
        problem = "contains joints, muscles and materials; use tables only with STEP files"
        raise InputError(problem, file=file)
    if suffix in STEP:
        changed = _changed(ExportSettings(), settings)
        return design_of_step(file, tables or Tables(), changed, time_limit)
    if suffix == ".py":
        design = script_design(file)
        return design.snapshot(_changed(design.settings, settings), file)
    if suffix != ".json":
        problem = (
            "is not a design in a known format (.json, .py, .step, .stp); for other CAD systems "
            "see docs/reference/snapshot.md"
        )
        raise InputError(problem, file=file)
    snapshot = read_snapshot(file)
    return replace(snapshot, settings=_changed(snapshot.settings, settings))


def _changed(base: ExportSettings, settings: Mapping[str, Any] | None) -> ExportSettings:
    return from_plain(ExportSettings, to_plain(base) | dict(settings or {}), "--set")
