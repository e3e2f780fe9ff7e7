"""Summaries of runs as lines of text."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from cardsflow_fmu.cosim.pacing import describe_timeliness

from .estimation import describe_event
from .verdict import failure_text

WORST = 5
"""Number of signals of each kind in a short text."""


def describe_summary(summary: Mapping[str, Any], *, every: bool = False) -> list[str]:
    """Return a summary as lines of text.

    Args:
        summary: Result of `summarize` or `summarize_system`.
        every: Whether to include all signals instead of the worst of each kind.
    """
    limit = None if every else WORST
    failed = failure_text(summary)
    lines = [] if failed is None else [failed]
    lines += [f"FAULT: {describe_event(event)}" for event in summary.get("faults") or ()]
    lines += [f"WARNING: {warning}" for warning in summary.get("warnings") or ()]
    lines += [_title(summary), *_tracking_lines(summary, limit), *_force_lines(summary, limit)]
    lines += _estimation_lines(summary, limit)
    lines += _torque_lines(summary, limit)
    lines += _infeasible_lines(summary, limit)
    lines += _real_time_lines(summary)
    lines += _engine_lines(summary)
    lines += _contact_lines(summary)
    if summary["real_time_factor"] is not None:
        lines.append(
            f"speed       {summary['real_time_factor']:.1f} x real time, "
            f"first step after {summary['first_step_after_s']:.1f} s"
        )
    return lines


def _engine_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the line with the engines, if the summary has them."""
    engines = summary.get("engine")
    if not engines:
        return []
    engine_text = ", ".join(f"{role} {engine}" for role, engine in engines.items())
    missing = summary.get("not_in_c") or {}
    why = "".join(f"; {role} in Python: not in C: {feature}" for role, feature in missing.items())
    return [f"engine      {engine_text}; master {summary['master']}{why}"]


def _contact_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the error of the contact friction law, if any."""
    friction = summary.get("contact_friction") or {"excess": 0.0}
    if not friction["excess"]:
        return []
    return [
        f"friction    {friction['law']}: friction between the x and y directions is up to "
        f'{friction["excess"]:.0%} too strong; world.friction_law = "cone" is exact but slower'
    ]


def _real_time_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return the timing of a real-time run, and the exchanges with hardware."""
    lines = []
    hardware, real_time = summary.get("hardware"), summary.get("real_time")
    if hardware is not None:
        lines.append(
            f"hardware    {hardware['link'] or 'address from the environment'}, {hardware['mode']}"
        )
        if hardware["round_trip"] is not None:
            lines[0] += (
                f": {hardware['missed']} exchanges missed, "
                f"{hardware.get('clamped') or 0} commands clamped, oldest state "
                f"{_text(hardware['oldest_state'], 1e3)} ms "
                f"({hardware.get('old_states') or 0} steps on states older than 2 steps), "
                "round trip median "
                f"{_text(hardware['round_trip']['median'], 1e6)}, "
                f"99 % {_text(hardware['round_trip']['p99'], 1e6)} us"
            )
    if real_time is not None:
        lines.append(
            f"real time   {describe_timeliness(real_time)}; scheduling {real_time['scheduling']}"
        )
    return lines


def _title(summary: Mapping[str, Any]) -> str:
    period = summary.get("control_period")
    control = "" if period is None else f"control every {period:.6g} s, "
    scheme = f"{summary['scheme']} coupling, " if "scheme" in summary else ""
    return (
        f"{summary['experiment']}: {summary['duration']:.6g} s, steps of {summary['step']:.6g} s, "
        f"{control}{scheme}{summary['status']}"
    )


def _tracking_lines(summary: Mapping[str, Any], limit: int | None) -> list[str]:
    """Return the RMS tracking error, and the errors of the signals."""
    tracking = summary["tracking"]
    if tracking["rms"] is None:
        return []
    rows = {
        name: f"RMS {_text(error['rms'])}, max {_text(error['max'])} {error['unit']}"
        for name, error in tracking["per_signal"].items()
    }
    worst = _by_size(rows, lambda name: tracking["per_signal"][name]["max"])
    title = f"tracking    RMS tracking error {_text(tracking['rms'])} {tracking['unit']}"
    return [title, *_rows(rows, worst, limit)]


def _estimation_lines(summary: Mapping[str, Any], limit: int | None) -> list[str]:
    """Return the errors of the estimate, if any."""
    estimate = summary.get("estimation")
    if not estimate:
        return []
    signals = estimate["per_signal"]
    rows = {
        name: f"error RMS {_text(e['rms'])}, max {_text(e['max'])} {e['unit']}, standard deviation "
        f"up to {_text(e['largest_sd'])}"
        for name, e in signals.items()
    }
    title = f"estimate    valid {estimate['valid_share']:.1%} of the time, "
    title += f"mean innovation {_text(estimate['innovation'])}"
    lines = [title if estimate["feeds"] else f"{title}; not used by the controller"]
    if estimate.get("fitted"):
        lines.append(
            "  no joint encoders: q and y are from the pose that fits each measurement best"
        )
    return [*lines, *_rows(rows, _by_size(rows, lambda name: signals[name]["max"]), limit)]


def _by_size(names: Iterable[str], size: Callable[[str], float | None]) -> list[str]:
    """Sort names by size in descending order; sizes that are not finite come first."""
    sizes = {name: size(name) for name in names}
    size_of = {name: math.inf if value is None else value for name, value in sizes.items()}
    return sorted(size_of, key=lambda name: -size_of[name])


def _rows(rows: Mapping[str, str], worst: Sequence[str], limit: int | None) -> list[str]:
    """Return one line per signal: all signals, or the worst if there are too many."""
    names = list(rows) if limit is None or len(rows) <= limit else worst[:limit]
    width = max((len(name) for name in names), default=0)
    lines = [f"  {name:<{width}} {rows[name]}" for name in names]
    more = len(rows) - len(names)
    return [*lines, f"  and {more} smaller; use --verbose"] if more else lines


def _force_lines(summary: Mapping[str, Any], limit: int | None) -> list[str]:
    forces = summary["forces"]
    if forces["min"] is None:
        return []
    title = f"forces      {_text(forces['min'], digits=4)} to {_text(forces['max'], digits=4)} N"
    rows, muscles = {}, forces["per_muscle"]
    for name, muscle in muscles.items():
        line = f"{_text(muscle['min'], digits=4)} to {_text(muscle['max'], digits=4)} N"
        if muscle["f_min"] is not None:
            upper = "unlimited" if muscle["f_max"] is None else f"{muscle['f_max']:.4g}"
            line += f", limits {muscle['f_min']:.4g} to {upper}"
        rows[name] = line
    return [title, *_rows(rows, _by_size(rows, lambda name: muscles[name]["max"]), limit)]


def _torque_lines(summary: Mapping[str, Any], limit: int | None) -> list[str]:
    """Return torques or forces of joint motors, if any."""
    motors = (summary.get("torques") or {}).get("per_motor") or {}
    rows = {}
    for name, motor in motors.items():
        low, high = (_text(motor[side], digits=4) for side in ("min", "max"))
        rows[name] = f"{low} to {high} {motor['unit']}"
        bounds = [motor["tau_min"], motor["tau_max"]]
        if bounds != [None, None]:
            limits = ["unlimited" if bound is None else f"{bound:.4g}" for bound in bounds]
            rows[name] += f", limits {limits[0]} to {limits[1]}"
    title = ["torques"] if motors else []
    return [*title, *_rows(rows, _by_size(rows, lambda name: motors[name]["max"]), limit)]


def _infeasible_lines(summary: Mapping[str, Any], limit: int | None) -> list[str]:
    if summary["infeasible_ticks"] is None:
        return []
    lines = [f"infeasible  {summary['infeasible_ticks']} of {summary['ticks']} ticks"]
    not_converged = summary.get("not_converged_ticks")
    if not_converged:
        lines[0] += f", and {not_converged} not converged"
    slack = summary["slack"]
    if summary.get("fallback_ticks"):
        lines[0] += f", and {summary['fallback_ticks']} with the fallback of mpc"
    if slack["first_at_s"] is not None:
        lines[0] += (
            f", between {slack['first_at_s']:.6g} and {slack['last_at_s']:.6g} s; shortfall:"
        )
        signals = slack["per_signal"]
        rows = {n: f"up to {_text(s['max'])} {s['unit']}" for n, s in signals.items()}
        worst = _by_size(rows, lambda name: signals[name]["max"])
        shown = {n.removeprefix("slack."): row for n, row in rows.items()}
        lines += _rows(shown, [n.removeprefix("slack.") for n in worst], limit)
    if slack["limits_dropped_ticks"]:
        lines.append(f"  joint limits were violated at {slack['limits_dropped_ticks']} ticks")
    return lines


def _text(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    """Format a number multiplied by a scale; None is a number that is not finite."""
    return "not finite" if value is None else f"{scale * value:.{digits}g}"
