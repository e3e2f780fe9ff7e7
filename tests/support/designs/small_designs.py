"""Small designs for tests: boxes in components, joints between them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from addin_sdfusion.snapshot import (
    BodySnapshot,
    DesignSnapshot,
    GroupSnapshot,
    JointSnapshot,
    MotionSnapshot,
    MuscleSnapshot,
    OccurrenceSnapshot,
    PointSnapshot,
    PointUse,
)

from .design_strategies import mass_of

Z = (0.0, 0.0, 1.0)


def box(size: Sequence[float], at: Sequence[float] = (0, 0, 0), mass: float = 1.0) -> Any:
    """Return mass, centre of mass and inertia of a box along the axes."""
    a, b, c = (s * s for s in size)
    return mass, np.array(at, dtype=float), mass / 12.0 * np.diag([b + c, a + c, a + b])


def cylinder(radius: float, length: float, at: Sequence[float], mass: float, axis: int) -> Any:
    across = mass * (3.0 * radius**2 + length**2) / 12.0
    J = np.diag([across] * 3)
    J[axis, axis] = 0.5 * mass * radius**2
    return mass, np.array(at, dtype=float), J


def turned(part: Any, R: Any) -> Any:
    mass, com, J = part
    return mass, R @ com, R @ J @ R.T


def body(
    path: str, part: Any = None, name: str = "Body1", sign: int = 1, **more: Any
) -> BodySnapshot:
    mass = mass_of([box((0.1, 0.2, 0.3)) if part is None else part], sign)
    return BodySnapshot(name, path, **{"mass": mass, "material": "Steel", **more})


def part(path: str, parent: str = "", **more: Any) -> OccurrenceSnapshot:
    return OccurrenceSnapshot(path, parent, path.rpartition("+")[2].rpartition(":")[0], **more)


def revolute(name: str, one: str | None, two: str | None, **more: Any) -> JointSnapshot:
    motion = MotionSnapshot(
        "rotation", Z, more.pop("value", 0.0), more.pop("lower", None), more.pop("upper", None)
    )
    origin = (0.2, 0.1, 0.0)
    given = {"origin_one": origin, "origin_two": origin, "motions": (motion,), **more}
    return JointSnapshot(name, given.pop("kind", "revolute"), one, two, **given)


def rigid(name: str, one: str | None, two: str | None) -> JointSnapshot:
    return JointSnapshot(name, "rigid", one, two)


def group(link: str, *paths: str, **more: Any) -> GroupSnapshot:
    return GroupSnapshot(f"EXPORT_{link}", paths or (f"{link}:1",), **more)


def via(
    muscle: str, number: int, link: str, at: Sequence[float], path: str = "", **more: Any
) -> Any:
    use = PointUse("via", link, muscle, number, **more)
    return PointSnapshot(
        f"P{muscle}{number}", path, tuple(map(float, at)), f"{muscle}.{number}", use
    )


def muscles(*names: str) -> tuple[MuscleSnapshot, ...]:
    return tuple(MuscleSnapshot(name, f_min=1.0, f_max=50.0) for name in names)


def arm(**more: Any) -> DesignSnapshot:
    """Return a valid design: base, upper and lower arm, one muscle over both joints."""
    names = ("base:1", "upper:1", "lower:1")
    places = ((0.0, 0.0, 0.0), (0.2, 0.0, 0.0), (0.5, 0.0, 0.0))
    given = {
        "occurrences": tuple(part(n, grounded=n == "base:1") for n in names),
        "bodies": tuple(
            body(n, box((0.1, 0.2, 0.3), at)) for n, at in zip(names, places, strict=True)
        ),
        "groups": (group("base"), group("upper"), group("lower")),
        "joints": (
            revolute("shoulder", "upper:1", "base:1"),
            revolute("elbow", "lower:1", "upper:1", origin_one=(0.4, 0, 0), origin_two=(0.4, 0, 0)),
        ),
        "points": (
            via("flexor", 1, "base", (0.0, 0.1, 0.0), "base:1"),
            via("flexor", 2, "upper", (0.3, 0.1, 0.0), "upper:1"),
            via("flexor", 3, "lower", (0.5, 0.05, 0.0), "lower:1"),
        ),
        "muscles": muscles("flexor"),
        **more,
    }
    return DesignSnapshot("arm", **given)
