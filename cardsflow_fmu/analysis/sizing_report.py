"""Sizing results as tables of text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from cardsflow_fmu.utils.text_table import table


def describe_sizes(sizes: dict[str, Any]) -> str:
    """The sizing by `size` as tables of text."""
    parts = [
        f"{sizes['points']} points from {sizes['begin']:g} to {sizes['end']:g} s, forces by "
        f"{sizes['method']}, needed f_max with a margin of {100 * sizes['margin']:g} %"
    ]
    parts += list(_warnings(sizes))
    heads = [
        "muscle",
        "peak [N]",
        "at [s]",
        "rms [N]",
        "needed f_max [N]",
        "f_max [N]",
        "at f_min",
        "at f_max",
        "power [W]",
    ]
    rows = [_muscle_cells(row) for row in sizes["muscles"]]
    parts.append(table(heads, rows))
    if any(row["torque_down"] is not None for row in sizes["coordinates"]):
        rows = [
            [row["name"], _number(row["torque_down"]), _number(row["torque_up"])]
            for row in sizes["coordinates"]
        ]
        parts.append(table(["coordinate", "least torque margin down", "up"], rows))
    parts.append(_bottleneck_words(sizes))
    return "\n\n".join(part for part in parts if part)


def _warnings(sizes: dict[str, Any]) -> Iterator[str]:
    """Warnings about the numbers."""
    if sizes["impossible_points"]:
        yield (
            f"at {sizes['impossible_points']} of {sizes['points']} points no strength is enough: "
            "the muscles cannot pull in that direction, or f_min is too large"
        )
    elif sizes["infeasible_points"]:
        yield (
            f"at {sizes['infeasible_points']} of {sizes['points']} points the muscles are too weak "
            "as they are; peak, rms and power are those of the other points"
        )


def _muscle_cells(row: dict[str, Any]) -> list[str]:
    power = f"{_number(row['peak_power'])} / -{_number(row['peak_braking_power'])}"
    return [
        row["name"],
        _number(row["peak"]),
        _number(row["peak_time"]),
        _number(row["rms"]),
        _number(row["needed_f_max"]),
        "unlimited" if row["f_max"] is None else _number(row["f_max"]),
        f"{100 * row['share_at_f_min']:.0f} %",
        f"{100 * row['share_at_f_max']:.0f} %",
        power,
    ]


def _bottleneck_words(sizes: dict[str, Any]) -> str:
    peak = sizes["least_peak"]
    if peak is None:
        return ""
    text = (
        f"however the forces are distributed, at {peak['time']:.4g} s the strongest muscle needs "
        f"{peak['force']:.4g} N"
    )
    if not sizes["bottlenecks"]:
        return f"{text}; no attachment changes that"
    lines = [f"{text}; what it gains from attachments moved by 1 mm:"]
    for entry in sizes["bottlenecks"][:3]:
        x, y, z = entry["direction"]
        lines.append(
            f"  {entry['gain']:.3g} N: via point {entry['via_point']} of {entry['muscle']} on "
            f"{entry['link']}, along ({x:.2f}, {y:.2f}, {z:.2f})"
        )
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
