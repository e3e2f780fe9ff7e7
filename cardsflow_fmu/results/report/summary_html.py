"""Summaries of runs as HTML tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cardsflow_fmu.results.estimation import describe_event
from cardsflow_fmu.results.verdict import failure_text

from .html import table


def summary_tables(summary: Mapping[str, Any]) -> list[str]:
    """Return tables of the run, its tracking errors, forces and shortfalls.

    Args:
        summary: The summary of a run; missing parts are omitted.
    """
    tracking = (summary.get("tracking") or {}).get("per_signal") or {}
    forces = (summary.get("forces") or {}).get("per_muscle") or {}
    torques = (summary.get("torques") or {}).get("per_motor") or {}
    slack = (summary.get("slack") or {}).get("per_signal") or {}
    faults = summary.get("faults") or ()
    missing = {name: s for name, s in slack.items() if s["max"]}
    return [
        html
        for html in (
            table(("faults and decisions",), ([describe_event(e)] for e in faults)),
            table(("", ""), _overview(summary)),
            table(
                ("tracking", "RMS", "largest", "unit"),
                ([name, e["rms"], e["max"], e["unit"]] for name, e in tracking.items()),
            ),
            table(
                ("force", "min [N]", "max [N]", "f_min [N]", "f_max [N]"),
                ([n, f["min"], f["max"], f["f_min"], f["f_max"]] for n, f in forces.items()),
            ),
            table(
                ("motor", "smallest", "largest", "tau_min", "tau_max", "unit"),
                (
                    [n, t["min"], t["max"], t["tau_min"], t["tau_max"], t["unit"]]
                    for n, t in torques.items()
                ),
            ),
            table(
                ("shortfall at infeasible ticks", "largest", "unit"),
                ([name, s["max"], s["unit"]] for name, s in missing.items()),
            ),
        )
        if html
    ]


def short_outcome(summary: Mapping[str, Any]) -> list[str]:
    """Return status, tracking errors and infeasible ticks of a run as plain text."""
    parts = [failure_text(summary) or str(summary.get("status", "complete"))]
    tracking = summary.get("tracking") or {}
    if tracking.get("rms") is not None:
        unit = tracking.get("unit", "")
        parts.append(f"RMS tracking error {tracking['rms']:.3g} {unit}")
        parts.append(f"largest error of a signal {tracking['max']:.3g} {unit}")
    ticks = summary.get("ticks")
    for key in ("infeasible_ticks", "not_converged_ticks"):
        count = summary.get(key)
        if ticks and count is not None and (count or key == "infeasible_ticks"):
            outcome = key.removesuffix("_ticks").replace("_", " ")
            parts.append(f"{count} of {ticks} ticks {outcome}")
    return parts


def _overview(summary: Mapping[str, Any]) -> list[list[Any]]:
    """Return labels and values of the summary, in the order of `_ROWS`."""
    unit = (summary.get("tracking") or {}).get("unit")
    rows = [[label.format(unit=unit), _value(summary, key)] for label, key in _ROWS]
    engines = [[f"engine of the {role}", n] for role, n in (summary.get("engine") or {}).items()]
    k = [key for _, key in _ROWS].index("master")
    rows[k:k] = engines
    return [row for row in rows if row[1] is not None]


def _value(summary: Mapping[str, Any], key: str) -> Any:
    """Return the value of a dotted key; None if missing."""
    value: Any = summary
    for name in key.split("."):
        value = (value or {}).get(name)
    return value if key != "hardware.link" else value or None


_ROWS = (
    ("experiment", "experiment"),
    ("robot", "robot"),
    ("cable set", "cable_set"),
    ("status", "status"),
    ("failure", "failure"),
    ("error", "error"),
    ("duration [s]", "duration"),
    ("step [s]", "step"),
    ("control period [s]", "control_period"),
    ("coupling scheme", "scheme"),
    ("RMS tracking error [{unit}]", "tracking.rms"),
    ("maximum tracking error [{unit}]", "tracking.max"),
    ("ticks", "ticks"),
    ("infeasible ticks", "infeasible_ticks"),
    ("not converged ticks", "not_converged_ticks"),
    ("ticks with the fallback of mpc", "fallback_ticks"),
    ("ticks beyond the deadline of mpc", "late_ticks"),
    ("computation time per tick, median [s]", "solve_time.median"),
    ("computation time per tick, maximum [s]", "solve_time.max"),
    ("master", "master"),
    ("hardware", "hardware.link"),
    ("hardware mode", "hardware.mode"),
    ("missed exchanges", "hardware.missed"),
    ("oldest hardware state [s]", "hardware.oldest_state"),
    ("round trip, median [s]", "hardware.round_trip.median"),
    ("round trip, 99 % [s]", "hardware.round_trip.p99"),
    ("late steps", "real_time.behind"),
    ("maximum lateness of a step [s]", "real_time.lateness.max"),
    ("scheduling", "real_time.scheduling"),
    ("real-time factor", "real_time_factor"),
)
"""Labels of rows, and keys of the summary."""
