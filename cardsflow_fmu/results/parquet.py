"""Results as Parquet, with units, versions, seed and experiment in the metadata; needs pyarrow."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.utils.csv_table import require_table

from .run_data import ExperimentRunData, RunData

KEY = b"cardsflow"
"""Of the metadata: JSON with units, summary, versions, seed and experiment."""


def require_parquet() -> Any:
    """The module pyarrow.

    Raises:
        InputError: It is missing.
    """
    try:
        import pyarrow
    except ImportError:
        what = "Parquet needs pyarrow: pip install 'cardsflow[parquet]'"
        raise InputError(what) from None
    return pyarrow


def parquet_bytes(result: RunData) -> bytes:
    """A result as the content of a .parquet, a column a signal.

    Raises:
        InputError: pyarrow is missing.
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
    """The result in a .parquet.

    Args:
        file: From `parquet_bytes`, or any table of numbers.

    Raises:
        InputError: pyarrow is missing, or the file cannot be read.
    """
    pa = require_parquet()
    import pyarrow.parquet as pq

    try:
        table = pq.ParquetFile(file).read()
        rows = np.column_stack([column.to_numpy() for column in table.columns])
        rows = rows.astype(np.float64, copy=False)
        metadata = json.loads((table.schema.metadata or {}).get(KEY, b"{}"))
    except OSError as error:  # pyarrow's own errors of damaged files are OSErrors or ValueErrors
        reason = error.strerror or "is no Parquet file"
        raise InputError(f"cannot be read: {reason}", file=file) from None
    except (pa.ArrowException, ValueError, TypeError, RecursionError) as error:
        what = f"is no table of results: {' '.join(str(error).split())}"
        raise InputError(what, file=file) from None
    if not isinstance(metadata, dict) or not isinstance(metadata.get("summary", {}), dict):
        raise InputError("is not what a run writes: its metadata", file=file)
    require_table(table.column_names, rows, file)
    units = {f.name: _unit(f.metadata) for f in table.schema}
    return RunData(
        tuple(table.column_names), rows, units, metadata.get("summary", {}), {file.name: file}
    )


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    return (metadata or {}).get(b"unit", b"").decode()


def _metadata(result: RunData) -> dict[str, Any]:
    """Plain JSON for readers without this package."""
    experiment = result.experiment if isinstance(result, ExperimentRunData) else None
    return {
        "units": dict(result.units),
        "summary": result.summary,
        "versions": result.summary.get("versions", {}),
        "seed": result.summary.get("seed"),
        "experiment": None if experiment is None else experiment_data(experiment),
    }
