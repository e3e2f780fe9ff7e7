"""Files of every kind, damaged at random: read or refused in one line, in 1 GiB and 10 s.

A mutation's kind and number alone decide it. A tenth of CARDSFLOW_MUTATIONS is tried of each kind,
20 if it is not set; a failure names its number and keeps its files.
"""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import pytest
from support.damaged.kinds import KINDS

MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "200")) // 10
CHUNK = 500
"""So many are tried in one process."""

NEEDS = {"parquet": "pyarrow", "step": "OCP", "step tables": "OCP"}
"""The module of an extra without which a kind is not tried."""

TESTS = Path(__file__).parents[2]
ALONE = {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(TESTS)}  # a thread takes much of a GiB

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are Linux's"),
]


@pytest.mark.parametrize("kinds", [[*KINDS][k::8] for k in range(8)], ids=", ".join)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, kinds: list[str]) -> None:
    kinds = [kind for kind in kinds if kind not in NEEDS or find_spec(NEEDS[kind])]
    for kind in kinds:
        (tmp_path / kind).mkdir()
        KINDS[kind].make(tmp_path / kind)
    for first, end in pairwise([*range(0, MUTATIONS, CHUNK), MUTATIONS]):
        words = [str(first), str(end), str(tmp_path), *kinds]
        done = subprocess.run(
            [sys.executable, "-m", "support.damaged.trial", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | ALONE,
            check=False,
        )
        assert done.returncode == 0, f"{done.returncode}: {done.stdout[-4000:]}"
