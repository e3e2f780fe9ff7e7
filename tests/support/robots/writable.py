"""Descriptions without numbers that files cannot represent."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from typing import Any

from addin_sdfusion.robot.formats.writing.xml_text import written


def writable(value: Any) -> Any:
    """Return the object with zeros for numbers that are too small for files."""
    if isinstance(value, float):
        return written(value)
    if isinstance(value, tuple):
        return tuple(map(writable, value))
    if is_dataclass(value) and not isinstance(value, type):
        changed = {field.name: writable(getattr(value, field.name)) for field in fields(value)}
        return replace(value, **changed)
    return value
