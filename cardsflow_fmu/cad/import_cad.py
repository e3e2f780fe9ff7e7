"""Import of a CAD design as a robot folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from addin_sdfusion.exporting.export import Exported, export_robot
from addin_sdfusion.records import from_plain, to_plain
from addin_sdfusion.robot import InputError
from addin_sdfusion.settings import ExportSettings
from addin_sdfusion.snapshot import DesignSnapshot
from addin_sdfusion.snapshot_file import read_snapshot

from .script import script_design
from .step_design import Tables
from .step_process import TIME_LIMIT, design_of_step

STEP = (".step", ".stp")
"""Suffixes of STEP files."""


def import_cad(
    file: str | Path,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    tables: Tables | None = None,
    time_limit: float = TIME_LIMIT,
) -> Exported:
    """Write the robot folder of a design, like the add-in in Fusion.

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
    return export_robot(read_design(file, settings, tables, time_limit), folder)


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
        what = "contains joints, muscles and materials; use tables only with STEP files"
        raise InputError(what, file=file)
    if suffix in STEP:
        changed = _changed(ExportSettings(), settings)
        return design_of_step(file, tables or Tables(), changed, time_limit)
    if suffix == ".py":
        design = script_design(file)
        return design.snapshot(_changed(design.settings, settings), file)
    if suffix != ".json":
        what = (
            "is not a design in a known format (.json, .py, .step, .stp); for other CAD systems "
            "see docs/reference/snapshot.md"
        )
        raise InputError(what, file=file)
    snapshot = read_snapshot(file)
    return replace(snapshot, settings=_changed(snapshot.settings, settings))


def _changed(base: ExportSettings, settings: Mapping[str, Any] | None) -> ExportSettings:
    return from_plain(ExportSettings, to_plain(base) | dict(settings or {}), "--set")
