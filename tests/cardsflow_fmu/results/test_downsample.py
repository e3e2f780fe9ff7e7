from __future__ import annotations

import numpy as np
import pytest

from cardsflow_fmu.results.report.downsample import downsample, evenly_spaced


@pytest.mark.parametrize("count", [1, 5, 4000, 4001, 30_000, 99_999])
def test_downsampled_points_are_points_of_the_line_with_its_extremes(count: int) -> None:
    rng = np.random.default_rng(count)
    x, y = np.sort(rng.normal(size=count)), rng.normal(size=count)
    y[count // 3] = 50.0  # a single peak
    kept_x, kept_y = downsample(x, y)
    assert len(kept_x) <= min(2 * 2000 + 2, count) or count <= 4000
    rows = np.searchsorted(x, kept_x)
    np.testing.assert_array_equal(y[rows], kept_y)
    assert (np.diff(rows) > 0).all()
    assert (rows[0], rows[-1]) == (0, count - 1)
    assert kept_y.max() == y.max()
    assert kept_y.min() == y.min()


def test_every_group_keeps_its_minimum_and_maximum() -> None:
    y = np.random.default_rng(0).normal(size=1000)
    kept = set(downsample(np.arange(1000.0), y, bins=100)[0].astype(int))
    for group in np.arange(1000).reshape(100, 10):
        assert {group[y[group].argmin()], group[y[group].argmax()]} <= kept


def test_gaps_are_preserved() -> None:
    y = np.zeros(50_000)
    y[20_000:30_000] = np.nan
    x, kept = downsample(np.arange(50_000.0), y)
    np.testing.assert_array_equal(np.isnan(kept), (x >= 20_000) & (x < 30_000))


@pytest.mark.parametrize("count", [0, 1, 7, 4000, 4001, 600_000])
def test_evenly_spaced_rows_include_both_ends(count: int) -> None:
    rows = evenly_spaced(count)
    assert len(rows) <= 4001
    assert (len(rows) == 0) == (count == 0)
    if count:
        assert (rows[0], rows[-1]) == (0, count - 1)
