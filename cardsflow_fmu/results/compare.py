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
Part = tuple[RunData, Rows, list[int]]
"""A result, and the rows and columns of it to compare."""

_TIME_TOLERANCE = 1e-9
_BLOCK_SIZE = 2**20


def compare(
    first: str | Path,
    second: str | Path,
    atol: float = 0.0,
    rtol: float = 0.0,
    columns: Sequence[str] = (),
) -> dict[str, Any]:
    """Compare two results at common times.

    Args:
        first: Results folder, or a table (.csv).
        second: Results folder or table to compare with.
        atol: Absolute tolerance, in the unit of each column.
        rtol: Relative tolerance, as fraction of the magnitude of the second result.
        columns: Patterns of columns, such as `q.*` (default: all columns).

    Returns:
        Plain data: `equal`, whether all columns exist and are within the tolerances; `columns` by
        name; `missing` columns and `rows` of each result.

    Raises:
        InputError: A result cannot be read, or a tolerance is negative.
    """
    for key, value in (("--atol", atol), ("--rtol", rtol)):
        if not value >= 0:
            raise InputError(f"must not be negative, not {value!r}", key=key)
    return compare_results(
        read_results(Path(first)), read_results(Path(second)), atol, rtol, columns
    )


def compare_results(
    a: RunData,
    b: RunData,
    atol: float = 0.0,
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
    missing = [[n for n in names if n not in index] for index in indices]
    rows_a, rows_b = _common_rows(a["time"], b["time"])
    common = [n for n in names if all(n in index for index in indices)]
    compared: dict[str, dict[str, Any]] = {}
    block = max(1, _BLOCK_SIZE // max(1, len(rows_a)))
    for begin in range(0, len(common), block):
        block_names = common[begin : begin + block]
        columns_a, columns_b = ([index[n] for n in block_names] for index in indices)
        pairs = ((a, rows_a, columns_a), (b, rows_b, columns_b))
        block_columns = _compare_rows(*pairs, atol, rtol)
        for name, column in zip(block_names, block_columns, strict=True):
            compared[name] = column | {"unit": a.units.get(name) or b.units.get(name) or ""}
    counts = [len(a.rows), len(b.rows)]
    same_rows = counts == [len(rows_a), len(rows_a)]
    beyond = [name for name, column in compared.items() if column["beyond"]]
    return {
        "equal": not beyond and not any(missing) and same_rows and bool(compared),
        "atol": atol,
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
    bounds = f"{comparison['atol']:g}"
    if comparison["rtol"]:
        bounds += f" + {comparison['rtol']:g} x magnitude"
    beyond = f"{len(comparison['beyond'])} of {len(rows)} columns exceed {bounds}"
    lines.append(f"equal within {bounds}" if comparison["equal"] else f"different: {beyond}")
    return "\n".join(line for line in lines if line)


def _common_rows(a: FloatArray, b: FloatArray) -> tuple[Rows, Rows]:
    """Return the rows of two results at equal times."""
    if not len(a) or not len(b):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    rows, partners = [], []
    for begin in range(0, len(a), _BLOCK_SIZE):
        times = a[begin : begin + _BLOCK_SIZE]
        after = np.searchsorted(b, times).clip(0, len(b) - 1)
        before = (after - 1).clip(0)
        nearest = np.where(np.abs(b[before] - times) < np.abs(b[after] - times), before, after)
        tolerance = _TIME_TOLERANCE * np.maximum(1.0, np.abs(times))
        matches = np.flatnonzero(np.abs(b[nearest] - times) <= tolerance)
        rows.append(matches + begin)
        partners.append(nearest[matches])
    return np.concatenate(rows), np.concatenate(partners)


def _compare_rows(a: Part, b: Part, atol: float, rtol: float) -> list[dict[str, Any]]:
    """Return the comparison of each column, computed in blocks of rows to limit the memory."""
    rows = len(a[1])
    if not rows:
        return [{"largest": None, "at": None, "beyond": True}] * len(a[2])
    blocks = []
    for begin in range(0, rows, _BLOCK_SIZE):
        block = slice(begin, begin + _BLOCK_SIZE)
        part_a, part_b = (run.rows[at[block, np.newaxis], columns] for run, at, columns in (a, b))
        blocks.append(_compare_columns(part_a, part_b, a[0]["time"][a[1][block]], atol, rtol))
    return [_merge(parts) for parts in zip(*blocks, strict=True)]


def _merge(blocks: Sequence[tuple[float, float, bool]]) -> dict[str, Any]:
    """Return the comparison of a column from those of its blocks.

    The largest difference is None if it is not finite.
    """
    largest, at, _ = max(blocks, key=lambda block: block[0])
    beyond = any(block[2] for block in blocks)
    return {"largest": largest if math.isfinite(largest) else None, "at": at, "beyond": beyond}


def _compare_columns(
    a: FloatArray, b: FloatArray, time: FloatArray, atol: float, rtol: float
) -> list[tuple[float, float, bool]]:
    """Return the largest difference of each column, its time, and whether it is too large."""
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    with np.errstate(invalid="ignore", over="ignore"):
        difference = np.where(same, 0.0, np.abs(a - b))
        excess = np.where(same, -np.inf, difference - (atol + rtol * np.abs(b)))
    difference[np.isnan(difference)] = np.inf
    excess[np.isnan(excess)] = np.inf
    k = difference.argmax(axis=0)
    largest = difference[k, np.arange(a.shape[1])].tolist()
    beyond: list[bool] = np.any(excess > 0, axis=0).tolist()
    return list(zip(largest, time[k].tolist(), beyond, strict=True))


def _sort_key(column: dict[str, Any]) -> float:
    """Return the largest difference of a column; infinity if it is not finite."""
    return float("inf") if column["largest"] is None else float(column["largest"])
