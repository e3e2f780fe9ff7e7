"""Warnings and failure of a run: infeasible ticks, large tracking errors, lost estimates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cardsflow_fmu.cosim.signals.reaction import DECISIONS
from cardsflow_fmu.experiment.settings.estimator import CALIBRATION_FILE

from .estimation import UPDATED_CALIBRATION, changed_offsets

_MAX_RATIO, _WARNING_RATIO = 0.5, 0.2
"""Maximum ratio of the tracking error to the range of the reference: of a run that succeeds, and
of one without a warning."""
_SMALL_ERROR = 0.01
"""Minimum tracking error for a warning, in [rad] or [m]."""
_MAX_SHARE = 0.01
"""Maximum share of infeasible or not converged ticks of a run that succeeds."""
MAX_MISSED_SHARE, FAILED_MISSED_SHARE = 0.01, 0.2
"""Maximum shares of missed exchanges of a run without a warning, and of a run that succeeds."""
NOT_FOLLOWED = "reference not followed"
"""Failure of a run with large tracking errors."""
_MAX_NAMES = 3
"""Maximum number of joints in a line."""


def problems(summary: Mapping[str, Any]) -> list[str]:
    """Return warnings about a run, the most severe first.

    Args:
        summary: Result of `summarize` or `summarize_system`, or the summary.json of a run.
    """
    checks = (
        _missed_exchanges,
        _lost_estimate,
        _changed_offsets,
        _infeasible,
        _not_converged,
        _fallbacks,
        _contact_errors,
        _tracking_errors,
    )
    return [line for problem in checks for line in problem(summary)]


def failure(summary: Mapping[str, Any]) -> str | None:
    """Return why a run that reached its end failed; None if it succeeded."""
    for event in summary.get("faults") or ():
        if event.get("decision") == DECISIONS[4]:
            return f"joints stopped at {event['time']:.6g} s: the muscles cannot hold the pose"
    if _large_errors(summary, _MAX_RATIO)[0]:
        return NOT_FOLLOWED
    ticks = summary.get("ticks") or 0
    for key, name in (("infeasible_ticks", "infeasible"), ("not_converged_ticks", "not converged")):
        count = summary.get(key) or 0
        if count > _MAX_SHARE * ticks:
            return f"{count} of {ticks} ticks {name}"
    missed, exchanges = _exchanges(summary)
    if missed > FAILED_MISSED_SHARE * exchanges:
        return f"{missed} of {exchanges} exchanges with the hardware missed"
    return None


def failure_text(summary: Mapping[str, Any]) -> str | None:
    """Return the line about a failed run, such as `FAILED: reference not followed`, or None."""
    return f"FAILED: {summary['failure']}" if summary.get("status") == "failed" else None


def _exchanges(summary: Mapping[str, Any]) -> tuple[int, int]:
    """Return the numbers of missed and of all exchanges with hardware."""
    hardware = summary.get("hardware") or {}
    return hardware.get("missed") or 0, hardware.get("exchanges") or 0


def _missed_exchanges(summary: Mapping[str, Any]) -> list[str]:
    missed, exchanges = _exchanges(summary)
    if missed <= MAX_MISSED_SHARE * exchanges:
        return []
    return [
        f"{missed} of {exchanges} exchanges with the hardware missed: control used older states; "
        "check the connection, and whether the device and this computer keep up"
    ]


def _lost_estimate(summary: Mapping[str, Any]) -> list[str]:
    """Report invalid estimates."""
    estimate = summary.get("estimation") or {}
    if estimate.get("first_lost_at_s") is None:
        return []
    share = estimate.get("not_converged_share")
    unsolved = f" (its horizon did not converge in {share:.1%})" if share else ""
    return [
        f"the estimate was invalid in {1 - estimate['valid_share']:.1%} of the run{unsolved}, "
        f"first at t = {estimate['first_lost_at_s']:.6g} s; final status: {estimate['status']}"
    ]


def _changed_offsets(summary: Mapping[str, Any]) -> list[str]:
    """Report length offsets that have drifted."""
    changed = sorted(
        changed_offsets(summary).items(), key=lambda pair: -abs(pair[1]["end"] - pair[1]["start"])
    )
    if not changed:
        return []
    rows = [
        f"{name} by {1e3 * (row['end'] - row['start']):.3g} mm (sd {1e3 * row['sd']:.2g} mm)"
        for name, row in changed[:_MAX_NAMES]
    ]
    if len(changed) > _MAX_NAMES:
        rows.append(f"less at {len(changed) - _MAX_NAMES} more")
    return [
        f"length offsets have changed: {', '.join(rows)}; to use them, copy {UPDATED_CALIBRATION} "
        f"to the robot's folder as {CALIBRATION_FILE} and set estimator.offset = 'calibrated'"
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
    shortfalls = [
        f"up to {rows[name]['max']:.3g} {rows[name]['unit']} at {name.removeprefix('slack.')}"
        for name in worst[:_MAX_NAMES]
    ]
    if len(worst) > _MAX_NAMES:
        shortfalls.append(f"less at {len(worst) - _MAX_NAMES} more")
    torques = all(rows[name]["unit"] in ("N.m", "N") for name in worst)
    quantity = "torque shortfall" if torques else "shortfall"
    return [f"{line}; {quantity} {', '.join(shortfalls)}" if shortfalls else line]


def _not_converged(summary: Mapping[str, Any]) -> list[str]:
    count, ticks = summary.get("not_converged_ticks"), summary.get("ticks")
    if not count:
        return []
    reason = "feasible forces may exist, but none were found"
    return [f"{count} of {ticks} ticks not converged: {reason}"]


def _fallbacks(summary: Mapping[str, Any]) -> list[str]:
    count, ticks = summary.get("fallback_ticks"), summary.get("ticks")
    late, lines = summary.get("late_ticks") or 0, []
    if late:
        reason = "set controller.deadline higher or controller.nodes lower"
        lines.append(f"{late} of {ticks} ticks reached controller.deadline; {reason}")
    if count:
        reason = "mpc found no motion, so the computed torque determined the forces"
        advice = "" if late else "; set controller.iterations higher or controller.horizon lower"
        lines.append(f"{count} of {ticks} ticks with the fallback: {reason}{advice}")
    return lines


def _contact_errors(summary: Mapping[str, Any]) -> list[str]:
    """Report contact forces that did not converge to the friction cone."""
    friction = summary.get("contact_friction") or {}
    if not (count := friction.get("not_converged_steps")):
        return []
    return [
        f"contact forces of {count} of {friction['steps']} steps not converged: they violate "
        f"Coulomb's law by up to {friction['error']:.3g} m/s"
    ]


def _tracking_errors(summary: Mapping[str, Any]) -> list[str]:
    """Report tracking errors that are large compared to the range of the reference."""
    large, ranges = _large_errors(summary, _MAX_RATIO)
    verdict = "not tracked" if large else "tracked poorly"
    if not large:
        large, ranges = _large_errors(summary, _WARNING_RATIO)
    if not large:
        return []
    name = max(large, key=lambda n: float(large[n]["max"]))
    row, others = large[name], f", and {len(large) - 1} more" if len(large) > 1 else ""
    return [
        f"the reference is {verdict}: tracking error up to {row['max']:.3g} {row['unit']} at "
        f"{name}{others}; range of the reference {ranges[row['unit']]:.3g} {row['unit']}"
    ]


def _large_errors(
    summary: Mapping[str, Any], ratio: float
) -> tuple[dict[str, Any], dict[str, float]]:
    """Return the signals with large tracking errors, and the range of the reference by unit."""
    rows = (summary.get("tracking") or {}).get("per_signal") or {}
    ranges: dict[str, float] = {}
    for row in rows.values():
        if row.get("moves") is None:
            return {}, {}
        ranges[row["unit"]] = max(ranges.get(row["unit"], 0.0), float(row["moves"]))
    large = {
        name: row
        for name, row in rows.items()
        if row["max"] > max(ratio * ranges[row["unit"]], _SMALL_ERROR)
    }
    return large, ranges
