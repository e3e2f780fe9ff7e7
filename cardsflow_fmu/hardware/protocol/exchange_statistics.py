"""Statistics of the exchanges with hardware in the summary of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray

_MAX_AGE = 2
"""Age of an old state, in steps."""


def exchange_statistics(columns: Mapping[str, FloatArray]) -> dict[str, Any]:
    """Return missed exchanges, clamped commands, round trip times and ages; empty without hardware.

    A step is one exchange.

    Args:
        columns: Recorded signals, shape (rows,) each.
    """
    missed, trips = columns.get("missed"), columns.get("round_trip_time")
    if missed is None or trips is None or "age" not in columns:
        return {}
    if len(missed) < 2:
        empty = dict.fromkeys(("missed", "clamped", "round_trip", "oldest_state", "old_states"))
        return {"hardware": {"exchanges": 0, **empty, "unit": "s"}}
    median, p99 = np.quantile(trips[1:], [0.5, 0.99])
    ages, step = columns["age"][1:], columns["time"][1] - columns["time"][0]
    return {
        "hardware": {
            "exchanges": len(missed) - 1,
            "missed": int(missed[-1]),
            "clamped": int(columns["clamped"][-1]),
            "round_trip": {
                "median": float(median),
                "p99": float(p99),
                "max": float(trips[1:].max()),
            },
            "oldest_state": float(ages.max()),
            "old_states": int(np.count_nonzero(ages > _MAX_AGE * step)),
            "unit": "s",
        }
    }
