"""Summaries of runs as lines of text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cardsflow_fmu.cosim.pacing import describe_timeliness


def describe_summary(summary: Mapping[str, Any]) -> list[str]:
    """A short text, a line a topic.

    Args:
        summary: From `summarize` or `summarize_system`.
    """
    lines = [f"WARNING: {warning}" for warning in summary.get("warnings") or ()]
    lines += [_title(summary), *_tracking_lines(summary), *_force_lines(summary)]
    lines += _torque_lines(summary)
    lines += _infeasible_lines(summary)
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
    """Engines of the participants and the master; older summaries have none."""
    engines = summary.get("engine")
    if not engines:
        return []
    named = ", ".join(f"{role} {engine}" for role, engine in engines.items())
    missing = summary.get("not_in_c") or {}
    why = "".join(f"; {role} in Python: C does not have {what}" for role, what in missing.items())
    return [f"engine      {named}; master {summary['master']}{why}"]


def _contact_lines(summary: Mapping[str, Any]) -> list[str]:
    """The error of the friction between bodies, where there is one."""
    friction = summary.get("contact_friction") or {"excess": 0.0}
    if not friction["excess"]:
        return []
    return [
        f"friction    {friction['law']}: what slides between x and y brakes up to "
        f'{friction["excess"]:.0%} too much; world.friction_law = "cone" is exact and slower'
    ]


def _real_time_lines(summary: Mapping[str, Any]) -> list[str]:
    """Timeliness of a run by the clock, and exchanges with the hardware; where there were any."""
    lines = []
    hardware, real_time = summary.get("hardware"), summary.get("real_time")
    if hardware is not None:
        lines.append(
            f"hardware    {hardware['link'] or 'as the environment says'}, {hardware['mode']}"
        )
        if hardware["round_trip"] is not None:
            lines[0] += (
                f": {hardware['missed']} exchanges missed, oldest state "
                f"{_text(hardware['oldest_state'], 1e3)} ms, round trip median "
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
    return (
        f"{summary['experiment']}: {summary['duration']:.6g} s, steps of {summary['step']:.6g} s, "
        f"{control}{summary['coupling']} coupling, {summary['status']}"
    )


def _tracking_lines(summary: Mapping[str, Any]) -> list[str]:
    tracking = summary["tracking"]
    if tracking["rms"] is None:
        return []
    unit = tracking["unit"]
    lines = [f"tracking    RMS {_text(tracking['rms'])}, max {_text(tracking['max'])} {unit}"]
    lines += [
        f"  {name:<9} RMS {_text(error['rms'])}, max {_text(error['max'])} {error['unit']}"
        for name, error in tracking["per_signal"].items()
    ]
    return lines


def _force_lines(summary: Mapping[str, Any]) -> list[str]:
    forces = summary["forces"]
    if forces["min"] is None:
        return []
    lines = [f"forces      {_text(forces['min'], digits=4)} to {_text(forces['max'], digits=4)} N"]
    for name, muscle in forces["per_muscle"].items():
        line = f"  {name:<9} {_text(muscle['min'], digits=4)} to {_text(muscle['max'], digits=4)} N"
        if muscle["f_min"] is not None:
            upper = "unlimited" if muscle["f_max"] is None else f"{muscle['f_max']:.4g}"
            line += f", bounds {muscle['f_min']:.4g} to {upper}"
        lines.append(line)
    return lines


def _torque_lines(summary: Mapping[str, Any]) -> list[str]:
    """Torques or forces of motors at joints, where there are any."""
    motors = (summary.get("torques") or {}).get("per_motor") or {}
    lines = ["torques"] if motors else []
    for name, motor in motors.items():
        low, high = (_text(motor[side], digits=4) for side in ("min", "max"))
        line = f"  {name:<9} {low} to {high} {motor['unit']}"
        bounds = [motor["tau_min"], motor["tau_max"]]
        if bounds != [None, None]:
            words = ["unlimited" if bound is None else f"{bound:.4g}" for bound in bounds]
            line += f", bounds {words[0]} to {words[1]}"
        lines.append(line)
    return lines


def _infeasible_lines(summary: Mapping[str, Any]) -> list[str]:
    if summary["infeasible_ticks"] is None:
        return []
    lines = [f"infeasible  {summary['infeasible_ticks']} of {summary['ticks']} ticks"]
    undecided = summary.get("not_converged_ticks")
    if undecided:
        lines[0] += f", and {undecided} not converged"
    slack = summary["slack"]
    if slack["first_at_s"] is not None:
        lines[0] += f", between {slack['first_at_s']:.6g} and {slack['last_at_s']:.6g} s, missing:"
        lines += [
            f"  {name.removeprefix('slack.'):<9} up to {_text(missing['max'])} {missing['unit']}"
            for name, missing in slack["per_signal"].items()
        ]
    if slack["limits_dropped_ticks"]:
        lines.append(f"  joint limits could not be kept at {slack['limits_dropped_ticks']} ticks")
    return lines


def _text(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    """A number, scaled; what was not finite has no number in the summary."""
    return "no number" if value is None else f"{scale * value:.{digits}g}"
