"""Reader of the summary and the units of a run, with checks."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError, create_model

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file
from cardsflow_fmu.experiment.config.file import require_sizes

_Number = float | None


class _Summary(BaseModel):
    """Keys of a summary that this package reads, with their types; other keys are allowed."""

    model_config = ConfigDict(strict=True)

    status: Literal["complete", "failed", "incomplete"]


def _model(base: type[BaseModel] | None = None, **types: Any) -> Any:
    """Return a model with optional keys."""
    config = None if base else ConfigDict(strict=True)
    keys: dict[str, Any] = {key: (type_, None) for key, type_ in types.items()}
    return create_model("Table", __base__=base, __config__=config, **keys)


def _rows(*columns: str) -> Any:
    """Return the type of rows by name, which require columns with numbers and units."""
    keys: dict[str, Any] = {c: (str if c == "unit" else _Number, ...) for c in columns}
    row: Any = create_model("Row", __config__=ConfigDict(strict=True), **keys)
    return Mapping[str, row] | None


def _table(**types: Any) -> Any:
    return _model(**types) | None


_SUMMARY = _model(
    _Summary,
    **dict.fromkeys(("duration", "step", "real_time_factor", "first_step_after_s"), _Number),
    **dict.fromkeys(("ticks", "infeasible_ticks", "not_converged_ticks"), _Number),
    **dict.fromkeys(("fallback_ticks", "late_ticks"), _Number),
    **dict.fromkeys(("solve_time", "engine", "files", "versions"), _table()),
    experiment=str,
    error=str | None,
    warnings=list[Any] | None,
    tracking=_table(rms=_Number, max=_Number, per_signal=_rows("rms", "max", "unit")),
    forces=_table(min=_Number, max=_Number, per_muscle=_rows("min", "max", "f_min", "f_max")),
    torques=_table(per_motor=_rows("min", "max", "tau_min", "tau_max", "unit")),
    slack=_table(per_signal=_rows("max", "unit")),
    contact_friction=_table(excess=_Number, not_converged_steps=_Number, error=_Number),
    hardware=_table(missed=_Number, exchanges=_Number, round_trip=_table()),
    real_time=_table(lateness=_table()),
)


def read_summary(file: Path) -> dict[str, Any]:
    """Read the summary of a run."""
    summary = _read(file)
    try:
        _SUMMARY.model_validate(summary)
    except ValidationError as error:
        raise _invalid(file, ".".join(map(str, error.errors()[0]["loc"][:2]))) from None
    return summary


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
