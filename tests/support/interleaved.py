"""Interleaved timing of alternatives, so that changes of the machine's speed cancel."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path

RESULTS = Path(__file__).parents[2] / "benchmarks.json"


def interleaved(
    alternatives: Mapping[str, Callable[[], object]], *, calls: int, rounds: int = 30
) -> dict[str, float]:
    """Return the time of a call of each alternative, in [s]: the best of many blocks of calls."""
    best = dict.fromkeys(alternatives, float("inf"))
    for _ in range(rounds):
        for name, call in alternatives.items():
            begin = time.perf_counter()
            for _ in range(calls):
                call()
            best[name] = min(best[name], (time.perf_counter() - begin) / calls)
    return best


def record(name: str, **figures: float | str) -> None:
    """Print results and store them in benchmarks.json."""
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    known[name] = figures
    RESULTS.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n")
    text = ", ".join(
        f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}"
        for key, value in figures.items()
    )
    print(f"\n{name}: {text}")
