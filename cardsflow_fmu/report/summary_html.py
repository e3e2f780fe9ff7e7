"""Summaries of runs as HTML tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .html import table


def summary_tables(summary: Mapping[str, Any]) -> list[str]:
    """Tables of the course of a run, of its errors, its forces and what was missing.

    Args:
        summary: What a run has written; parts that it lacks are left out.
    """
    tracking = (summary.get("tracking") or {}).get("per_signal") or {}
    forces = (summary.get("forces") or {}).get("per_muscle") or {}
    slack = (summary.get("slack") or {}).get("per_signal") or {}
    missing = {name: s for name, s in slack.items() if s["max"]}
    return [
        part
        for part in (
            table(("", ""), _course(summary)),
            table(
                ("tracking", "RMS", "largest", "unit"),
                ([name, e["rms"], e["max"], e["unit"]] for name, e in tracking.items()),
            ),
            table(
                ("force", "smallest [N]", "largest [N]", "f_min [N]", "f_max [N]"),
                ([n, f["min"], f["max"], f["f_min"], f["f_max"]] for n, f in forces.items()),
            ),
            table(
                ("missing at infeasible ticks", "largest", "unit"),
                ([name, s["max"], s["unit"]] for name, s in missing.items()),
            ),
        )
        if part
    ]


def _course(summary: Mapping[str, Any]) -> list[list[Any]]:
    tracking, time = summary.get("tracking") or {}, summary.get("solve_time") or {}
    rows = [
        ["experiment", summary.get("experiment")],
        ["robot", summary.get("robot")],
        ["cable set", summary.get("cable_set")],
        ["status", summary.get("status")],
        ["error", summary.get("error")],
        ["duration [s]", summary.get("duration")],
        ["step [s]", summary.get("step")],
        ["control period [s]", summary.get("control_period")],
        ["coupling", summary.get("coupling")],
        [f"tracking, RMS [{tracking.get('unit')}]", tracking.get("rms")],
        [f"tracking, largest [{tracking.get('unit')}]", tracking.get("max")],
        ["ticks", summary.get("ticks")],
        ["infeasible ticks", summary.get("infeasible_ticks")],
        ["time of a tick, median [s]", time.get("median")],
        ["time of a tick, largest [s]", time.get("max")],
        *([f"engine of the {role}", name] for role, name in (summary.get("engine") or {}).items()),
        ["master", summary.get("master")],
        *_hardware(summary),
        ["speed over real time", summary.get("real_time_factor")],
        *(["warning", warning] for warning in summary.get("warnings") or ()),
    ]
    return [row for row in rows if row[1] is not None]


def _hardware(summary: Mapping[str, Any]) -> list[list[Any]]:
    """How hardware answered, and whether a run by the clock kept up."""
    hardware, pace = summary.get("hardware") or {}, summary.get("real_time") or {}
    trip, lateness = hardware.get("round_trip") or {}, pace.get("lateness") or {}
    return [
        ["hardware", hardware.get("link") or None],
        ["mode of the hardware", hardware.get("mode")],
        ["exchanges missed", hardware.get("missed")],
        ["oldest state of the hardware [s]", hardware.get("oldest_state")],
        ["round trip, median [s]", trip.get("median")],
        ["round trip, 99 % [s]", trip.get("p99")],
        ["steps behind the clock", pace.get("behind")],
        ["lateness of a step, largest [s]", lateness.get("max")],
        ["scheduling", pace.get("scheduling")],
    ]
