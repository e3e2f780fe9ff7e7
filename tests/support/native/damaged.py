"""Programs that open damaged files under sanitizers."""

from __future__ import annotations

import os
from pathlib import Path

from .targets import Target, run

MUTATIONS = int(os.environ.get("CARDSFLOW_MUTATIONS", "1000"))
BATCH = 5000
SANITIZED = Target(["gcc", "-O1", "-g", "-fsanitize=address,undefined"])


def count_rejected(program: list[str], *arguments: Path) -> int:
    """Return the number of rejected files; a run of the program opens thousands of files."""
    refused = 0
    for first in range(0, MUTATIONS, BATCH):
        count = min(BATCH, MUTATIONS - first)
        refused += int(run([*program, str(first), str(count), *arguments]))
    return refused
