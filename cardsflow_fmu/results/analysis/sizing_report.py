"""Sizing results as tables of text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cardsflow_fmu.utils.text_table import table


def describe_sizes(sizes: dict[str, Any]) -> str:
    """Return the result of `size` as tables of text."""
    sections = [
        f"{sizes['points']} points from {sizes['begin']:g} to {sizes['end']:g} s, forces by "
        f"{sizes['method']}, required f_max with a margin of {100 * sizes['margin']:g} %"
    ]
    sections += list(_warnings(sizes))
    heads = [
        "muscle",
        "peak [N]",
        "at [s]",
        "rms [N]",
        "required f_max [N]",
        "f_max [N]",
        "at f_min",
        "at f_max",
        "power [W]",
    ]
    rows = [_cells(row, "f_max", "f_min", "f_max") for row in sizes["muscles"]]
    if rows:
        sections.append(table(heads, rows))
    sections += list(_motor_tables(sizes["motors"]))
    if any(row["torque_down"] is not None for row in sizes["coordinates"]):
        rows = [
            [row["name"], _number(row["torque_down"]), _number(row["torque_up"])]
            for row in sizes["coordinates"]
        ]
        sections.append(table(["coordinate", "minimum torque margin down", "up"], rows))
    sections.append(_bottleneck_text(sizes))
    return "\n\n".join(section for section in sections if section)


def _warnings(sizes: dict[str, Any]) -> Iterator[str]:
    """Yield warnings about infeasible points."""
    if sizes["impossible_points"]:
        yield (
            f"at {sizes['impossible_points']} of {sizes['points']} points no f_max is sufficient: "
            "the muscles cannot produce the required direction of torque, or f_min is too large"
        )
    elif sizes["infeasible_points"]:
        yield (
            f"at {sizes['infeasible_points']} of {sizes['points']} points, muscles are too weak; "
            "peak, rms and power are from the other points"
        )


def _motor_tables(motors: list[dict[str, Any]]) -> Iterator[str]:
    """Yield one table per unit of torques or forces."""
    for unit in dict.fromkeys(row["unit"] for row in motors):
        per = f"[{unit.replace('.', '·')}]"
        heads = ["motor", f"peak {per}", "at [s]", f"rms {per}", f"required effort {per}"]
        heads += [f"tau_max {per}", "at tau_min", "at tau_max", "power [W]"]
        rows = [row for row in motors if row["unit"] == unit]
        yield table(heads, [_cells(row, "effort", "tau_min", "tau_max") for row in rows])


def _cells(row: dict[str, Any], needed: str, low: str, high: str) -> list[str]:
    power = f"{_number(row['peak_power'])} / -{_number(row['peak_braking_power'])}"
    return [
        row["name"],
        _number(row["peak"]),
        _number(row["peak_time"]),
        _number(row["rms"]),
        _number(row[f"needed_{needed}"]),
        "unlimited" if row[high] is None else _number(row[high]),
        f"{100 * row[f'share_at_{low}']:.0f} %",
        f"{100 * row[f'share_at_{high}']:.0f} %",
        power,
    ]


def _bottleneck_text(sizes: dict[str, Any]) -> str:
    peak = sizes["least_peak"]
    if peak is None:
        return ""
    text = (
        f"at {peak['time']:.4g} s, every force distribution requires a muscle force of at least "
        f"{peak['force']:.4g} N"
    )
    if not sizes["bottlenecks"]:
        return f"{text}; moving attachments does not reduce it"
    lines = [f"{text}; reduction by moving attachments by 1 mm:"]
    for entry in sizes["bottlenecks"][:3]:
        x, y, z = entry["direction"]
        lines.append(
            f"  {entry['gain']:.3g} N: via point {entry['via_point']} of {entry['muscle']} on "
            f"{entry['link']}, along ({x:.2f}, {y:.2f}, {z:.2f})"
        )
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
