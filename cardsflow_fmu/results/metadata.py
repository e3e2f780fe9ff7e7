"""Reader of the summary and the units of a run, with checks."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file
from cardsflow_fmu.experiment.config.file import require_sizes

_NUMBER = (int, float, type(None))
_TABLE = (dict, type(None))
_TYPES: dict[str, tuple[type, ...]] = {
    "status": (str,),
    "experiment": (str,),
    "error": (str, type(None)),
    "duration": _NUMBER,
    "step": _NUMBER,
    "ticks": _NUMBER,
    "infeasible_ticks": _NUMBER,
    "not_converged_ticks": _NUMBER,
    "fallback_ticks": _NUMBER,
    "late_ticks": _NUMBER,
    "real_time_factor": _NUMBER,
    "first_step_after_s": _NUMBER,
    "tracking": _TABLE,
    "forces": _TABLE,
    "torques": _TABLE,
    "slack": _TABLE,
    "solve_time": _TABLE,
    "contact_friction": _TABLE,
    "engine": _TABLE,
    "hardware": _TABLE,
    "real_time": _TABLE,
    "files": _TABLE,
    "versions": _TABLE,
    "warnings": (list, type(None)),
}

_NUMBERS = ["tracking.rms", "tracking.max", "forces.min", "forces.max"]
_NUMBERS += [f"contact_friction.{name}" for name in ("excess", "not_converged_steps", "error")]
_NUMBERS += ["hardware.missed", "hardware.exchanges"]

_INNER = {"hardware": "round_trip", "real_time": "lateness"}
"""Keys of nested tables."""

_ROWS = {
    "tracking": ("per_signal", ("rms", "max", "unit")),
    "forces": ("per_muscle", ("min", "max", "f_min", "f_max")),
    "torques": ("per_motor", ("min", "max", "tau_min", "tau_max", "unit")),
    "slack": ("per_signal", ("max", "unit")),
}


def read_summary(file: Path) -> dict[str, Any]:
    """Read the summary of a run."""
    summary = _read(file)
    require_summary(summary, file)
    return summary


def require_summary(summary: Mapping[str, Any], file: Path) -> None:
    """Check that data is the summary of a run."""
    if summary.get("status") not in ("complete", "failed", "incomplete"):
        raise _invalid(file, "status")
    for key, types in _TYPES.items():
        if key in summary and not isinstance(summary[key], types):
            raise _invalid(file, key)
    for key, inner in _INNER.items():
        if not isinstance((summary.get(key) or {}).get(inner), _TABLE):
            raise _invalid(file, f"{key}.{inner}")
    for key, (rows, columns) in _ROWS.items():
        if not _are_valid_rows((summary.get(key) or {}).get(rows), columns):
            raise _invalid(file, f"{key}.{rows}")
    for key in _NUMBERS:
        group, name = key.split(".")
        if not isinstance((summary.get(group) or {}).get(name), _NUMBER):
            raise _invalid(file, key)


def _are_valid_rows(rows: Any, columns: tuple[str, ...]) -> bool:
    """Return whether rows are tables with numbers and units in the given columns, or None."""
    if rows is None:
        return True
    return isinstance(rows, Mapping) and all(
        isinstance(row, Mapping)
        and set(columns) <= set(row)
        and all(isinstance(row[c], str if c == "unit" else _NUMBER) for c in columns)
        for row in rows.values()
    )


def read_units(file: Path) -> dict[str, str]:
    """Read the units of a table, by column name."""
    units = _read(file)
    for name, unit in units.items():
        if not isinstance(unit, str):
            raise _invalid(file, name[:80])
    return units


def _read(file: Path) -> dict[str, Any]:
    try:
        data = json.loads(read_file(file, limits.JSON).decode("utf-8-sig"))
    except RecursionError:
        raise InputError("is nested too deeply", file=file) from None
    except ValueError as error:
        raise InputError(f"is not valid JSON: {error}", file=file) from None
    if not isinstance(data, dict):
        raise InputError("is invalid", file=file)
    require_sizes(data, file)
    return data


def _invalid(file: Path, key: str) -> InputError:
    return InputError("is invalid", file=file, key=key)
