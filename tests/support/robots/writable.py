"""Descriptions without the numbers that files do not hold."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from addin_sdfusion.robot.formats.writing.xml_text import written


def writable(value: Any) -> Any:
    """The same with zeros if numbers are so small that files have zeros for them."""
    if isinstance(value, float):
        return written(value)
    if isinstance(value, tuple):
        return tuple(map(writable, value))
    if is_dataclass(value) and not isinstance(value, type):
        changed = {field.name: writable(getattr(value, field.name)) for field in fields(value)}
        return replace(value, **changed)
    return value
