"""Table of a study with one row per run, in the order of the runs."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import LEADING_COLUMNS, TRAILING_COLUMNS, Outcome
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.definition.tables import TableKind

_BLOCK = 1024
_FORMULAS = ("=", "+", "-", "@", "\t", "\r")  # first characters of formulas in spreadsheets

Rows = Callable[[], Iterator[tuple[Run, Outcome]]]


class Columns(NamedTuple):
    """The columns of a table.

    Attributes:
        variations: Names of the variations.
        metrics: Names of the metrics.
    """

    variations: tuple[str, ...]
    metrics: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, in order."""
        return (*LEADING_COLUMNS, *self.variations, *self.metrics, *TRAILING_COLUMNS)


def columns_of(study: Study) -> Columns:
    """Return the columns of a study's table."""
    return Columns(tuple(v.name for v in study.variations), study.metrics)


def write_tables(folder: Path, kinds: Iterable[TableKind], columns: Columns, rows: Rows) -> None:
    """Write the table in the formats of the study, row by row.

    Args:
        folder: The folder.
        kinds: Formats of the files `table.csv` and `table.parquet`.
        columns: The columns.
        rows: Function that returns the runs with their outcomes, in order; called for each format.

    Raises:
        StudyError: A file cannot be written.
    """
    writers = {"csv": _write_csv, "parquet": _write_parquet}
    for kind in kinds:
        file = folder / f"table.{kind}"
        temporary = folder / f".table.{kind}.tmp"
        try:
            temporary.unlink(missing_ok=True)  # it could be a link to another file
            writers[kind](temporary, columns, rows())
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


def _write_parquet(file: Path, columns: Columns, rows: Iterator[tuple[Run, Outcome]]) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    numeric = {"run": pa.int64()} | {name: pa.float64() for name in columns.metrics}
    kinds = {name: numeric.get(name, pa.string()) for name in columns.names}
    with file.open("xb") as stream:
        writer: Any = None
        for block in _blocks(rows):
            values = [row_values(columns, run, outcome) for run, outcome in block]
            by_name = dict(zip(columns.names, map(list, zip(*values, strict=True)), strict=True))
            if writer is None:  # a variation is numeric if it is numeric in the first block
                kinds |= {n: pa.float64() for n in columns.variations if _all_numbers(by_name[n])}
                schema = pa.schema(list(kinds.items()))
                writer = parquet.ParquetWriter(stream, schema, compression="zstd")
            arrays = [_array(pa, by_name[name], kinds[name]) for name in columns.names]
            writer.write_table(pa.Table.from_arrays(arrays, schema=writer.schema))
        if writer is not None:
            writer.close()


def _blocks(rows: Iterator[tuple[Run, Outcome]]) -> Iterator[list[tuple[Run, Outcome]]]:
    block: list[tuple[Run, Outcome]] = []
    for row in rows:
        block.append(row)
        if len(block) == _BLOCK:
            yield block
            block = []
    if block:
        yield block


def _all_numbers(values: list[Any]) -> bool:
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def _array(pa: Any, values: list[Any], kind: Any) -> Any:
    if kind == pa.string():
        values = [v if v is None or isinstance(v, str) else _text(v) for v in values]
    return pa.array(values, type=kind)


def units_text(columns: Columns, units: Mapping[str, str]) -> str:
    """Return the units of the metrics, as JSON."""
    return json_text({name: units.get(name, "") for name in columns.metrics}, indent=1) + "\n"
