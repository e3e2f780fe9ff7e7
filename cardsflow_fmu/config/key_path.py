"""Full keys of settings, such as `controller.kp.joint_1` or `start.y[2]`, and setting by them."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError

EVERY_OTHER = "*"
"""In a table by name: all names that it does not name."""

_PART = re.compile(r'"(?P<quoted>[^"]*)"|(?P<bare>[^."]+)')
_INDEXED = re.compile(r"(?P<name>.+)\[(?P<index>\d+)\]")


class PathError(InputError):
    """A key leads through what is no table, or past the end of a row."""


def split_path(key: str) -> list[str]:
    """The parts of a full key; a name with dots is in quotes: `controller.kp."hand.x"`.

    Args:
        key: The full key.

    Raises:
        InputError: It is not parts with dots between.
    """
    parts, position = [], 0
    while True:
        match = _PART.match(key, position)
        if match is None:
            raise InputError("is not names with dots between", key=key)
        parts.append(match["bare"] if match["quoted"] is None else match["quoted"])
        position = match.end()
        if position == len(key):
            return parts
        if key[position] != ".":
            raise InputError("is not names with dots between", key=key)
        position += 1


def join_path(parts: Iterable[str]) -> str:
    """The full key of parts."""
    return ".".join(f'"{part}"' if "." in part else part for part in parts)


def indexed(part: str) -> tuple[str, int | None]:
    """Name and index of a part such as `position[2]`; no index where there is none."""
    match = _INDEXED.fullmatch(part)
    return (part, None) if match is None else (match["name"], int(match["index"]))


def set_value(data: dict[str, Any], key: str, value: Any, file: Path) -> None:
    """Set a value by its full key, making tables on the way.

    Below one number for all names, the number becomes that of every other name.

    Args:
        data: The settings; changed.
        key: The full key.
        value: The value; copied.
        file: Where the settings come from, for the message.

    Raises:
        PathError: The key leads through what is no table, or past the end of a list.
    """
    *path, last = split_path(key)
    for part in path:
        inner = _row(data, part, key, file)
        if inner is None:
            inner = data.setdefault(part, {})
        if isinstance(inner, int | float) and not isinstance(inner, bool):
            inner = data[part] = {EVERY_OTHER: inner}
        if not isinstance(inner, dict):
            raise PathError(f"{part!r} is not a table", file=file, key=key)
        data = inner
    name, index = indexed(last)
    there = data.get(name)
    if index is None or not isinstance(there, list):
        data[last] = copy.deepcopy(value)
        return
    if index >= len(there):
        raise PathError(f"{name!r} has {len(there)} elements", file=file, key=key)
    there[index] = copy.deepcopy(value)


def _row(data: Mapping[str, Any], part: str, key: str, file: Path) -> Any:
    """The row of an array of tables, for a part such as `objects[0]`; None for other parts."""
    name, index = indexed(part)
    rows = data.get(name)
    if index is None or not isinstance(rows, list):
        return None
    if index >= len(rows):
        raise PathError(f"{name!r} has {len(rows)} elements", file=file, key=key)
    return rows[index]
