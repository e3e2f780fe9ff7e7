"""Import of a design, of whatever CAD system, as a robot's folder."""

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
"""What names of STEP files end with."""


def import_cad(
    file: str | Path,
    folder: str | Path,
    settings: Mapping[str, Any] | None = None,
    tables: Tables | None = None,
    time_limit: float = TIME_LIMIT,
) -> Exported:
    """Write the robot's folder of a design, as the add-in does inside Fusion.

    Args:
        file: A snapshot (.json), a program that draws with build123d (.py), which is run, or a
            STEP file (.step, .stp).
        folder: Where to; made if it does not exist.
        settings: Changes to the design's own settings, by their names in ExportSettings.
        tables: What a STEP file does not say.
        time_limit: How long the geometry kernel may take for a STEP file, in [s].

    Raises:
        RobotError: The design has errors; the exception carries all findings.
        InputError: The design cannot be read, a setting is wrong, or the folder cannot be written.
    """
    return export_robot(read_design(file, settings, tables, time_limit), folder)


def read_design(
    file: str | Path,
    settings: Mapping[str, Any] | None = None,
    tables: Tables | None = None,
    time_limit: float = TIME_LIMIT,
) -> DesignSnapshot:
    """Return the snapshot of a design; arguments and errors as of `import_cad`."""
    file = Path(file)
    suffix = file.suffix.lower()
    if tables is not None and suffix not in STEP:
        raise InputError("has joints, muscles and materials itself: tables are for STEP files",
                         file=file)  # fmt: skip
    if suffix in STEP:
        own = _changed(ExportSettings(), settings)
        return design_of_step(file, tables or Tables(), own, time_limit)
    if suffix == ".py":
        design = script_design(file)
        return design.snapshot(_changed(design.settings, settings), file)
    if suffix != ".json":
        what = (
            "is not a design in a known format (.json, .py, .step, .stp); how other CAD "
            "systems get here is in docs/reference/snapshot.md"
        )
        raise InputError(what, file=file)
    snapshot = read_snapshot(file)
    return replace(snapshot, settings=_changed(snapshot.settings, settings))


def _changed(own: ExportSettings, settings: Mapping[str, Any] | None) -> ExportSettings:
    return from_plain(ExportSettings, to_plain(own) | dict(settings or {}), "--set")
