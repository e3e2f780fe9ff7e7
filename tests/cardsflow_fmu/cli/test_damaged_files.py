"""Files of every kind, damaged at random: read or refused in one line, in 1 GiB and 10 s.

A mutation's kind and number alone decide it. A tenth of CARDSFLOW_MUTATIONS is tried of each kind,
20 if it is not set; a failure names its number and keeps its files.
"""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from support.damaged.kinds import KINDS

MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "200")) // 10
CHUNK = 500
"""So many are tried in one process."""

TESTS = Path(__file__).parents[2]
ALONE = {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(TESTS)}  # a thread takes much of a GiB

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are Linux's"),
]


@pytest.mark.parametrize("name", KINDS)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, name: str) -> None:
    if name == "parquet":
        pytest.importorskip("pyarrow")
    (tmp_path / "good").mkdir()
    KINDS[name].make(tmp_path / "good")
    for first, end in pairwise([*range(0, MUTATIONS, CHUNK), MUTATIONS]):
        done = subprocess.run(
            [sys.executable, "-m", "support.damaged.trial", name, str(first), str(end), tmp_path],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | ALONE,
            check=False,
        )
        assert done.returncode == 0, f"{done.returncode}: {done.stdout[-4000:]}"
