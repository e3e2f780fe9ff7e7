"""Warnings of a run, as lines: no forces that fit, a reference that is not followed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_FOLLOWED = 0.5
"""An error beyond this part of what the reference moves by is not following it."""
_MIN_ERROR = 0.01
"""Errors below it, in [rad] or [m], are small whatever the reference does."""
_NAMED = 3
"""Most joints that a line names."""


def problems(summary: Mapping[str, Any]) -> list[str]:
    """What is wrong with a run, the worst first; empty where nothing is.

    Args:
        summary: From `summarize` or `summarize_system`, or as a run has written it.
    """
    found = (_lost, _infeasible, _undecided, _slipping, _astray)
    return [line for problem in found for line in problem(summary)]


def _lost(summary: Mapping[str, Any]) -> list[str]:
    """When the estimate was not to be relied on."""
    estimate = summary.get("estimation") or {}
    if estimate.get("first_lost_at_s") is None:
        return []
    return [
        f"the estimate was lost in {1 - estimate['valid_share']:.1%} of the run, first at "
        f"t = {estimate['first_lost_at_s']:.6g} s; it ends {estimate['status']}"
    ]


def _infeasible(summary: Mapping[str, Any]) -> list[str]:
    count, ticks = summary.get("infeasible_ticks"), summary.get("ticks")
    if not count:
        return []
    slack = summary.get("slack") or {}
    line = f"{count} of {ticks} ticks infeasible"
    if slack.get("first_at_s") is not None:
        line += f", from t = {slack['first_at_s']:.6g} s"
    rows = {name: s for name, s in (slack.get("per_signal") or {}).items() if s["max"]}
    worst = sorted(rows, key=lambda name: -float(rows[name]["max"]))
    lacks = [
        f"{name.removeprefix('slack.')} lacks up to {rows[name]['max']:.3g} {rows[name]['unit']}"
        for name in worst[:_NAMED]
    ]
    if len(worst) > _NAMED:
        lacks.append(f"{len(worst) - _NAMED} more lack less")
    return ["; ".join([line, ", ".join(lacks)] if lacks else [line])]


def _undecided(summary: Mapping[str, Any]) -> list[str]:
    count, ticks = summary.get("not_converged_ticks"), summary.get("ticks")
    if not count:
        return []
    return [f"{count} of {ticks} ticks not converged: forces that fit may exist, none were found"]


def _slipping(summary: Mapping[str, Any]) -> list[str]:
    """Contact forces that friction cones did not converge to."""
    friction = summary.get("contact_friction") or {}
    if not (count := friction.get("not_converged_steps")):
        return []
    return [
        f"contact forces of {count} of {friction['steps']} steps not converged: contacts break "
        f"Coulomb's law by up to {friction['error']:.3g} m/s"
    ]


def _astray(summary: Mapping[str, Any]) -> list[str]:
    """Errors that are large beside what the reference moves by, of the same unit."""
    rows = (summary.get("tracking") or {}).get("per_signal") or {}
    moved: dict[str, float] = {}
    for row in rows.values():
        if row.get("moves") is None:
            return []
        moved[row["unit"]] = max(moved.get(row["unit"], 0.0), float(row["moves"]))
    lost = {
        name: row
        for name, row in rows.items()
        if row["max"] > max(_FOLLOWED * moved[row["unit"]], _MIN_ERROR)
    }
    if not lost:
        return []
    name = max(lost, key=lambda n: float(lost[n]["max"]))
    row, others = lost[name], f", and {len(lost) - 1} more" if len(lost) > 1 else ""
    return [
        f"the reference is not followed: {name} is up to {row['max']:.3g} {row['unit']} off{others}"
        f", while references move by up to {moved[row['unit']]:.3g} {row['unit']}"
    ]
