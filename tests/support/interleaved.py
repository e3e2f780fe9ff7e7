"""Timing of alternatives in turn: a drift of the machine's speed cancels in their ratios."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path

RESULTS = Path(__file__).parents[2] / "benchmarks.json"


def interleaved(
    alternatives: Mapping[str, Callable[[], object]], *, calls: int, rounds: int = 30
) -> dict[str, float]:
    """Time of one call of each alternative, in [s]: the best of many blocks of calls, in turn."""
    best = dict.fromkeys(alternatives, float("inf"))
    for _ in range(rounds):
        for name, call in alternatives.items():
            begin = time.perf_counter()
            for _ in range(calls):
                call()
            best[name] = min(best[name], (time.perf_counter() - begin) / calls)
    return best


def record(name: str, **figures: float | str) -> None:
    """Print figures and keep them in benchmarks.json."""
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    known[name] = figures
    RESULTS.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")
    text = ", ".join(
        f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in figures.items()
    )
    print(f"\n{name}: {text}")
