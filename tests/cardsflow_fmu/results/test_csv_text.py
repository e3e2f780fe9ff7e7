"""Text of numbers in tables: exact, shortest, and equal to the text of another library."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic_core import to_json

from cardsflow_fmu.utils.csv_table import rows_bytes

pytestmark = pytest.mark.native

RNG = np.random.default_rng(7)
FRACTION = 2**52


def bits(numbers: np.ndarray) -> np.ndarray:
    return numbers.astype(np.uint64).view(float).reshape(-1, 4)


def held(rows: np.ndarray) -> np.ndarray:
    """Return rows in which about half of the numbers are those of the row before."""
    is_new = RNG.random(rows.shape) < 0.5
    is_new[0] = True
    last = np.maximum.accumulate(np.where(is_new, np.arange(len(rows))[:, None], 0))
    return np.take_along_axis(rows, last, axis=0)


CASES = {
    "all bit patterns": bits(RNG.integers(0, 2**64, 40_000, np.uint64)),
    "measured values": np.round(RNG.normal(size=(10_000, 4)), 3),
    "times": 1e-3 * np.arange(20_000.0).reshape(-1, 4),
    "integers": RNG.integers(-(2**53), 2**53, (2_000, 4)).astype(float),
    "powers of ten": 10.0 ** np.arange(-323, 309).reshape(-1, 4),
    "powers of two": bits(np.arange(2048, dtype=np.uint64) * np.uint64(FRACTION)),
    "next to powers of two": bits(np.arange(1, 2045, dtype=np.uint64) * np.uint64(FRACTION) - 1),
    "smallest numbers": bits(np.arange(1000)),
    "held values": held(bits(RNG.integers(0, 2**64, 20_000, np.uint64))),
    "held short values": held(RNG.integers(-2, 3, (2_000, 4)) * 0.5),
    "one held column": held(RNG.integers(0, 2, (2_000, 1)).astype(float)),
    "special": np.array([[0.0, -0.0, np.nan, np.inf], [-np.inf, 1e15, 1e16, 5e-324]]),
}


@pytest.mark.parametrize("name", CASES)
def test_numbers_have_the_same_text_as_in_json(name: str) -> None:
    rows = CASES[name]
    expected = to_json(rows.tolist()).decode()[2:-2].replace("],[", "\n")
    assert rows_bytes(rows).decode() == expected


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (3, 1)])
def test_rows_of_any_shape(shape: tuple[int, int]) -> None:
    assert rows_bytes(np.ones(shape)) == b"\n".join([b"1.0"] * shape[0])


def test_columns_of_a_larger_table() -> None:
    assert rows_bytes(np.arange(12.0).reshape(3, 4)[:, 1::2]) == b"1.0,3.0\n5.0,7.0\n9.0,11.0"
