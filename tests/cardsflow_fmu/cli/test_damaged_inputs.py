"""Randomly damaged files of every kind are read or rejected in one line, within 1 GiB and 10 s.

The kind and the number of a mutation determine it. For each kind, a tenth of CARDSFLOW_MUTATIONS
is tested, or 20 if it is not set. A failure reports its number and keeps its files.
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
"""Number of mutations in one process."""

NEEDS = {"step": "OCP", "step tables": "OCP"}
"""Module of the extra that a kind requires; it is skipped without the module."""

_STEP = [kind for kind in KINDS if kind.startswith("step")]
_OTHERS = [kind for kind in KINDS if kind not in _STEP]
GROUPS = [_OTHERS[::2], _OTHERS[1::2], _STEP]
"""Kinds that one process reads; the kernel of STEP files requires much of the GiB."""

TESTS = Path(__file__).parents[2]
ALONE = {
    "OPENBLAS_NUM_THREADS": "1",
    "PYTHONPATH": str(TESTS),
}  # each thread requires much of the GiB

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are Linux's"),
]


@pytest.mark.parametrize("kinds", GROUPS, ids=", ".join)
def test_damaged_file_is_read_or_rejected(tmp_path: Path, kinds: list[str]) -> None:
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
