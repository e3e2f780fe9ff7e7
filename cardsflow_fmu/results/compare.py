"""Comparison of two results by column, with absolute and relative tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.text_table import table

from .columns import chosen_columns
from .run_data import RunData
from .saved_run import read_results

Rows = NDArray[np.int64]

_TIME_TOLERANCE = 1e-9
_BLOCK_SIZE = 2**20


def compare(
    first: str | Path,
    second: str | Path,
    tol: float = 0.0,
    rtol: float = 0.0,
    columns: Sequence[str] = (),
) -> dict[str, Any]:
    """Compare two results at common times.

    Args:
        first: Results folder, or a table: .csv, .parquet.
        second: Results folder or table to compare with.
        tol: Absolute tolerance, in the unit of each column.
        rtol: Relative tolerance, as fraction of the magnitude of the second result.
        columns: Patterns of columns, such as `q.*` (default: all columns).

    Returns:
        Plain data: `equal`, whether all columns exist and are within the tolerances; `columns` by
        name; `missing` columns and `rows` of each result.

    Raises:
        InputError: A result cannot be read, or a tolerance is negative.
    """
    for key, value in (("--atol", tol), ("--rtol", rtol)):
        if not value >= 0:
            raise InputError(f"must not be negative, not {value!r}", key=key)
    return compare_results(
        read_results(Path(first)), read_results(Path(second)), tol, rtol, columns
    )


def compare_results(
    a: RunData,
    b: RunData,
    tol: float = 0.0,
    rtol: float = 0.0,
    columns: Sequence[str] = (),
) -> dict[str, Any]:
    """Compare two loaded results; arguments and return value as for `compare`."""
    for result in (a, b):
        if "time" not in result.names:
            file = next(iter(result.files.values()), None)
            raise InputError("has no column 'time'", file=file)
    all_names = list(dict.fromkeys([*a.names, *b.names]))
    names = chosen_columns(all_names, columns) if columns else [n for n in all_names if n != "time"]
    indices = [{name: k for k, name in enumerate(result.names)} for result in (a, b)]
    missing = [[n for n in names if n not in own] for own in indices]
    rows_a, rows_b = _common_rows(a["time"], b["time"])
    common = [n for n in names if all(n in own for own in indices)]
    time, compared = a["time"][rows_a], {}
    block = max(1, _BLOCK_SIZE // max(1, len(time)))
    for begin in range(0, len(common), block):
        part = common[begin : begin + block]
        values_a, values_b = (
            np.take(result.rows, [index_of[n] for n in part], axis=1)[rows]
            for result, rows, index_of in zip((a, b), (rows_a, rows_b), indices, strict=True)
        )
        for name, column in zip(
            part, _compare_columns(values_a, values_b, time, tol, rtol), strict=True
        ):
            compared[name] = column | {"unit": a.units.get(name) or b.units.get(name) or ""}
    counts = [len(a.rows), len(b.rows)]
    same_rows = counts == [len(rows_a), len(rows_a)]
    beyond = [name for name, column in compared.items() if column["beyond"]]
    return {
        "equal": not beyond and not any(missing) and same_rows and bool(compared),
        "tol": tol,
        "rtol": rtol,
        "rows": {"first": counts[0], "second": counts[1], "common": len(rows_a)},
        "missing": {"first": missing[0], "second": missing[1]},
        "beyond": beyond,
        "columns": compared,
    }


def describe_comparison(comparison: dict[str, Any]) -> str:
    """Return a comparison as a table of text, the largest differences first, and a conclusion."""
    columns = sorted(comparison["columns"].items(), key=lambda item: -_sort_key(item[1]))
    rows = [
        [
            name,
            "not a number" if c["largest"] is None else f"{c['largest']:.3g} {c['unit']}".rstrip(),
            "" if c["at"] is None else f"{c['at']:.6g} s",
            "beyond" if c["beyond"] else "",
        ]
        for name, c in columns
    ]
    lines = [table(["column", "largest difference", "at", ""], rows)]
    for which in ("first", "second"):
        if comparison["missing"][which]:
            lines.append(f"missing in the {which}: {', '.join(comparison['missing'][which])}")
    counts = comparison["rows"]
    if counts["first"] != counts["common"] or counts["second"] != counts["common"]:
        lines.append(
            f"rows: {counts['first']} and {counts['second']}, "
            f"{counts['common']} of them at the same times"
        )
    bounds = f"{comparison['tol']:g}"
    if comparison["rtol"]:
        bounds += f" + {comparison['rtol']:g} x magnitude"
    beyond = f"{len(comparison['beyond'])} of {len(rows)} columns exceed {bounds}"
    lines.append(f"equal within {bounds}" if comparison["equal"] else f"different: {beyond}")
    return "\n".join(line for line in lines if line)


def _common_rows(a: FloatArray, b: FloatArray) -> tuple[Rows, Rows]:
    """Return the rows of two results at equal times."""
    if not len(a) or not len(b):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    after = np.searchsorted(b, a).clip(0, len(b) - 1)
    before = (after - 1).clip(0)
    nearest = np.where(np.abs(b[before] - a) < np.abs(b[after] - a), before, after)
    rows = np.flatnonzero(np.abs(b[nearest] - a) <= _TIME_TOLERANCE * np.maximum(1.0, np.abs(a)))
    return rows, nearest[rows]


def _compare_columns(
    a: FloatArray, b: FloatArray, time: FloatArray, tol: float, rtol: float
) -> list[dict[str, Any]]:
    """Return the largest difference of each column, its time, and whether it exceeds the tolerance.

    The largest difference is None if it is not finite.
    """
    if not len(time):
        return [{"largest": None, "at": None, "beyond": True}] * a.shape[1]
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.where(same, 0.0, np.abs(a - b))
        excess = np.where(same, -np.inf, difference - (tol + rtol * np.abs(b)))
    difference[np.isnan(difference)] = np.inf
    excess[np.isnan(excess)] = np.inf
    k = difference.argmax(axis=0)
    largest = difference[k, np.arange(a.shape[1])].tolist()
    beyond_any: list[bool] = np.any(excess > 0, axis=0).tolist()
    return [
        {"largest": value if math.isfinite(value) else None, "at": at, "beyond": beyond}
        for value, at, beyond in zip(largest, time[k].tolist(), beyond_any, strict=True)
    ]


def _sort_key(column: dict[str, Any]) -> float:
    """Return the largest difference of a column; infinity if it is not finite."""
    return float("inf") if column["largest"] is None else float(column["largest"])
