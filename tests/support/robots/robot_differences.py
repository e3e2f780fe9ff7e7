"""Differences between two robots, except for rounding."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

ROUNDING = 4e-15


def differences(a: Any, b: Any, where: str = "robot") -> Iterator[str]:
    """Yield every field that differs, with both values."""
    if is_dataclass(a) and type(a) is type(b):
        for field in fields(a):
            name = field.name
            yield from differences(getattr(a, name), getattr(b, name), f"{where}.{name}")
    elif isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
        for k, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from differences(x, y, f"{where}[{getattr(x, 'name', k)}]")
    elif isinstance(a, float) and isinstance(b, float):
        if a != b and not abs(a - b) <= ROUNDING * max(1.0, abs(a)):
            yield f"{where}: {a!r}, {b!r}"
    elif a != b:
        yield f"{where}: {str(a)[:200]}, {str(b)[:200]}"
