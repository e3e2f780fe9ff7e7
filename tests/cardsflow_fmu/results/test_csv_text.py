"""Text of numbers in tables: exact, also for unusual numbers."""

from __future__ import annotations

import numpy as np
import pytest

from cardsflow_fmu.utils.csv_table import rows_bytes

BITS = np.random.default_rng(7).integers(0, 2**64, 2_000, np.uint64)
CASES = {
    "all bit patterns": BITS.view(float),
    "powers of ten": 10.0 ** np.arange(-323, 309),
    "smallest numbers": np.arange(1000, dtype=np.uint64).view(float),
    "special": np.array([0.0, -0.0, np.inf, -np.inf, 1e15, 1e16, 5e-324, np.nan]),
}


@pytest.mark.parametrize("name", CASES)
def test_numbers_are_read_back_exactly(name: str) -> None:
    rows = CASES[name].reshape(-1, 4)
    lines = rows_bytes(rows).decode().split("\n")
    read = np.array([[float(number) for number in line.split(",")] for line in lines])
    assert np.array_equal(read, rows, equal_nan=True)
    assert np.array_equal(np.signbit(read), np.signbit(rows) & ~np.isnan(rows))


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (3, 1)])
def test_rows_of_any_shape(shape: tuple[int, int]) -> None:
    assert rows_bytes(np.ones(shape)) == b"\n".join([b"1.0"] * shape[0])


def test_columns_of_a_larger_table() -> None:
    assert rows_bytes(np.arange(12.0).reshape(3, 4)[:, 1::2]) == b"1.0,3.0\n5.0,7.0\n9.0,11.0"
