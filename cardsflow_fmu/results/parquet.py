"""Results as Parquet with metadata: units, versions, seed, experiment. Requires pyarrow."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import open_file
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.utils.csv_table import require_table
from cardsflow_fmu.utils.extras import install
from cardsflow_fmu.utils.interrupts import collect_interrupts

from .metadata import require_summary
from .run_data import ExperimentRunData, RunData

# limits of the file metadata that pyarrow accepts
_FOOTER_LIMITS = {
    "thrift_string_size_limit": 2 * limits.JSON,
    "thrift_container_size_limit": 10 * limits.COLUMNS,
}
KEY = b"cardsflow"
"""Key of the metadata: JSON with units, summary, versions, seed and experiment."""


def require_parquet() -> Any:
    """Return the module pyarrow.

    Raises:
        InputError: pyarrow is not installed.
    """
    try:
        import pyarrow
    except ImportError:
        what = f"Parquet requires pyarrow: {install('parquet')}"
        raise InputError(what) from None
    return pyarrow


def parquet_bytes(result: RunData) -> bytes:
    """Return a result as the content of a .parquet file, one column per signal.

    Raises:
        InputError: pyarrow is not installed.
    """
    pa = require_parquet()
    import pyarrow.parquet as pq

    fields = [
        pa.field(name, pa.float64(), nullable=False, metadata={"unit": result.units.get(name, "")})
        for name in result.names
    ]
    columns = [pa.array(np.ascontiguousarray(column)) for column in result.rows.T]
    schema = pa.schema(fields, metadata={KEY: json_text(_metadata(result))})
    memory = io.BytesIO()
    pq.write_table(
        pa.Table.from_arrays(columns, schema=schema),
        memory,
        compression="zstd",
        use_dictionary=False,
        column_encoding=dict.fromkeys(result.names, "BYTE_STREAM_SPLIT"),
    )
    return memory.getvalue()


def read_parquet(file: Path) -> RunData:
    """Read the result in a .parquet file.

    Args:
        file: A file from `parquet_bytes`, or any table of numbers.

    Raises:
        InputError: pyarrow is not installed, or the file cannot be read.
    """
    pa = require_parquet()
    import pyarrow.parquet as pq

    try:
        # pyarrow can lose a KeyboardInterrupt that is raised within its code
        with open_file(file, limits.TABLE) as stream, collect_interrupts() as interrupted:
            parquet = pq.ParquetFile(stream, **_FOOTER_LIMITS)
            _check_columns_and_size(parquet, pa, file)
            schema, names = parquet.schema_arrow, parquet.schema_arrow.names
            rows = np.empty((parquet.metadata.num_rows, len(names)))
            for k, begin in _row_groups(parquet, len(names)):
                if interrupted:
                    raise KeyboardInterrupt
                columns = parquet.read_row_group(k)
                for j, column in enumerate(columns.columns):
                    rows[begin : begin + columns.num_rows, j] = column.to_numpy()
        text = (schema.metadata or {}).get(KEY, b"{}")
        if len(text) > limits.JSON:
            raise InputError(f"its metadata {limits.too_large(limits.JSON)}", file=file)
        metadata = json.loads(text)
    except InputError:
        raise
    except OSError as error:  # pyarrow raises OSErrors or ValueErrors for damaged files
        reason = error.strerror or "is not a Parquet file"
        raise InputError(f"cannot be read: {reason}", file=file) from None
    except (pa.ArrowException, ValueError, TypeError, RecursionError) as error:
        what = f"is not a results table: {' '.join(str(error).split())}"
        raise InputError(what, file=file) from None
    if not isinstance(metadata, dict) or not isinstance(metadata.get("summary", {}), dict):
        raise InputError("has invalid metadata", file=file)
    require_table(names, rows, file)
    try:
        units = {f.name: _unit(f.metadata) for f in schema}
    except UnicodeDecodeError:
        raise InputError("has a unit that is not UTF-8", file=file) from None
    if metadata.get("summary"):
        require_summary(metadata["summary"], file)
    return RunData(tuple(names), rows, units, metadata.get("summary", {}), {file.name: file})


def _check_columns_and_size(parquet: Any, pa: Any, file: Path) -> None:
    """Check that all columns contain numbers and that the table is not too large."""
    metadata, schema = parquet.metadata, parquet.schema_arrow
    if len(schema) > limits.COLUMNS:
        raise InputError(f"has more than {limits.COLUMNS} columns", file=file)
    if metadata.num_rows > limits.ROWS:
        raise InputError(f"has more than {limits.ROWS} rows", file=file)
    if metadata.num_rows * len(schema) > limits.VALUES:
        raise InputError(f"has more than {limits.VALUES} numbers", file=file)
    for field in schema:
        kind = field.type
        if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or kind == pa.bool_()):
            what = f"is not a results table: column {field.name!r} has {kind} instead of numbers"
            raise InputError(what, file=file)


def _row_groups(parquet: Any, columns: int) -> Iterator[tuple[int, int]]:
    """Yield the index of each row group and its first row.

    Raises:
        ValueError: The row groups do not match the number of rows.
    """
    begin = 0
    for k in range(parquet.num_row_groups):
        group = parquet.metadata.row_group(k)
        if group.num_columns != columns or begin + group.num_rows > parquet.metadata.num_rows:
            raise ValueError("its row groups do not match its number of rows")
        yield k, begin
        begin += group.num_rows
    if begin != parquet.metadata.num_rows:
        raise ValueError("its row groups do not match its number of rows")


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    return (metadata or {}).get(b"unit", b"").decode()


def _metadata(result: RunData) -> dict[str, Any]:
    """Return the metadata as JSON, for readers without CARDSFlow."""
    experiment = result.experiment if isinstance(result, ExperimentRunData) else None
    return {
        "units": dict(result.units),
        "summary": result.summary,
        "versions": result.summary.get("versions", {}),
        "seed": result.summary.get("seed"),
        "experiment": None if experiment is None else experiment_data(experiment),
    }
