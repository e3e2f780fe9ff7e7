"""Table of a study with one row per run, in the order of the runs."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import LEADING_COLUMNS, TRAILING_COLUMNS, Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.definition.study import Study

_FORMULAS = ("=", "+", "-", "@", "\t", "\r")  # first characters of formulas in spreadsheets

Rows = Callable[[], Iterator[tuple[Run, Outcome]]]


class Columns(NamedTuple):
    """The columns of a table."""

    variations: tuple[str, ...]
    metrics: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, in order."""
        return (*LEADING_COLUMNS, *self.variations, *self.metrics, *TRAILING_COLUMNS)


def columns_of(study: Study) -> Columns:
    """Return the columns of a study's table."""
    return Columns(tuple(v.name for v in study.variations), study.metrics)


def write_table(file: Path, columns: Columns, rows: Rows) -> None:
    """Write the table row by row."""
    temporary = file.with_name(f".{file.name}.tmp")
    try:
        temporary.unlink(missing_ok=True)  # it could be a link to another file
        _write_csv(temporary, columns, rows())
        temporary.replace(file)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise StudyError(f"{file}: cannot be written: {error.strerror or error}") from None


def row_values(columns: Columns, run: Run, outcome: Outcome) -> list[Any]:
    """Return the values of a row: numbers, texts, or None for missing values."""
    return [
        run.index,
        run.hash,
        *(run.values[name] for name in columns.variations),
        *(outcome.metrics.get(name) for name in columns.metrics),
        "complete" if outcome.complete else "failed",
        outcome.error,
    ]


def _write_csv(file: Path, columns: Columns, rows: Iterator[tuple[Run, Outcome]]) -> None:
    with file.open("x", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(map(_escape_formula, columns.names))
        for run, outcome in rows:
            writer.writerow(map(_text, row_values(columns, run, outcome)))


def _text(value: Any) -> str:
    """Return a value as text, with numbers that can be read back exactly; empty for None."""
    if value is None:
        return ""
    if isinstance(value, str):
        return _escape_formula(value)
    return repr(value) if isinstance(value, float) else json_text(value)


def _escape_formula(text: str) -> str:
    """Return a text that spreadsheets do not interpret as a formula; values may be untrusted."""
    return f"'{text}" if text.startswith(_FORMULAS) else text


def units_text(columns: Columns, units: Mapping[str, str]) -> str:
    """Return the units of the metrics, as JSON."""
    return json_text({name: units.get(name, "") for name in columns.metrics}, indent=1) + "\n"
