"""Ten minutes at 1 kHz stream to disk with bounded memory.

CARDSFLOW_LONG=1 python -m pytest -n 0 -s tests/benchmarks/test_long_run.py   (some minutes)
"""

from __future__ import annotations

import os
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R

from cardsflow_fmu import Experiment, run

MINUTES = 10.0
MEBIBYTE = 2**20


def resident() -> int:
    """Return the anonymous memory of this process, in bytes."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("RssAnon"))


@pytest.mark.skipif("CARDSFLOW_LONG" not in os.environ, reason="takes minutes: CARDSFLOW_LONG=1")
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_ten_minutes_at_1_khz_stream_to_disk_with_bounded_memory(tmp_path: Path) -> None:
    end = 60.0 * MINUTES
    points = [{"time": 0.0, "q": 0.0}, {"time": end, "q": 0.3}]
    settings = {
        "run.duration": end,
        "controller.period": 0.01,
        "reference": {"spline": "linear", "points": points},
    }
    seen: list[tuple[int, int]] = []

    def look(done: int) -> None:
        if done >= 6400 * (1 + len(seen)):
            table = np.lib.format.open_memmap(tmp_path / "results.npy", mode="r")
            seen.append((resident(), len(table)))

    result = run(Experiment.load(PLANAR_2R, settings), tmp_path, coupling="direct", progress=look)
    assert result.complete
    assert len(result.rows) == 1000 * end + 1
    memory, written = zip(*seen, strict=True)
    print(f"memory {max(memory) / MEBIBYTE:.0f} MiB, table {written[-1]} rows")
    size = (tmp_path / "results.npy").stat().st_size
    assert size < 130e6  # as CSV 280 MB
    assert max(memory) - memory[0] < 16 * MEBIBYTE  # the rows alone are 120 MB
    steps = [b - a for a, b in pairwise(written)]
    assert min(steps) > 0
