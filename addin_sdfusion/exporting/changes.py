"""Differences between a robot and the previously exported robot."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from ..robot.model.joint import Joint
from ..robot.model.robot import Robot
from .manifest import digest

Contents = Mapping[str, tuple[str, str]]
"""A description and a fingerprint of each part, by its kind and name, such as `link arm`."""

_NUMBERS = "values changed"


def contents(robot: Robot) -> Contents:
    """Return descriptions and fingerprints of the named parts of a robot."""
    items: dict[str, tuple[str, Any]] = {}
    for link in robot.links:
        items[f"link {link.name}"] = f"{link.inertia.mass:.4g} kg", link
    for joint in robot.joints:
        items[f"joint {joint.name}"] = _joint(joint), joint
    for m in robot.muscles:
        forces = f"{m.f_min:g} to {m.f_max:g} N"
        text = f"{len(m.via_points)} points, {len(m.wraps)} wraps, {forces}, {m.model.kind}"
        items[f"muscle {m.name}"] = text, m
    for surface in robot.wrap_surfaces:
        text = f"{surface.shape} of {1000 * surface.radius:.4g} mm on {surface.link}"
        items[f"wrap surface {surface.name}"] = text, surface
    for frame in robot.task_frames:
        items[f"task point {frame.name}"] = f"on {frame.link}", frame
    return {name: (text, digest(repr(item).encode())) for name, (text, item) in items.items()}


def changes(before: Contents, after: Contents) -> Iterator[str]:
    """Yield a line for every new, removed or changed part."""
    for name in sorted({*before, *after}):
        if name not in before:
            yield f"{name} is new: {after[name][0]}"
        elif name not in after:
            yield f"{name} is removed"
        elif before[name] != after[name]:
            old, new = before[name][0], after[name][0]
            yield f"{name}: {_NUMBERS}" if old == new else f"{name}: {new}; before: {old}"


def _joint(joint: Joint) -> str:
    ranges = [
        f", {c.name} {_value(c.lower, c.unit)} to {_value(c.upper, c.unit)}"
        for c in joint.coordinates
        if c.is_limited
    ]
    return f"{joint.type} from {joint.parent} to {joint.child}{''.join(ranges)}"


def _value(value: float, unit: str) -> str:
    """Return a value in degrees or millimetres as text."""
    return f"{math.degrees(value):.4g}°" if unit == "rad" else f"{1000 * value:.4g} mm"
