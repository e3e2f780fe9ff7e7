"""Full keys of settings, such as `controller.kp.joint_1` or `start.y[2]`."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Collection, Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, TypeVar

from addin_sdfusion.robot import InputError, UnknownNameError
from addin_sdfusion.robot.json_text import json_text

EVERY_OTHER = "*"
"""Key of the value for all names that a table does not contain."""

T = TypeVar("T")

_QUOTED = r""""(?:[^"\\]|\\.)*"|'[^']*'"""
_PART = re.compile(rf"""(?P<quoted>{_QUOTED})|(?P<bare>[^."'][^."]*)""")
_SETTING = re.compile(rf"""(?P<key>(?>{_QUOTED}|[^."'=][^.=]*|\.)+)=(?P<value>.*)""", re.DOTALL)
_PLAIN = re.compile(r"""[^\s."'=\x00-\x1f\x7f][^."=\x00-\x1f\x7f]*""")
_BARE = re.compile(r"[A-Za-z0-9_-]+")
_INVALID_KEY = "must be names separated by dots; quote names with dots or quotes as in TOML"
_INDEXED = re.compile(r"(?P<name>.+)\[(?P<index>[0-9]{1,9})\]")


class PathError(InputError):
    """Error of a key: a part is not a table, or an index is beyond the end of a list."""


def split_path(key: str) -> list[str]:
    """Split a full key into parts. Names with dots are quoted: `controller.kp."hand.x"`.

    Args:
        key: The full key, with quotes as in TOML: "..." with escapes, '...' without.

    Raises:
        InputError: The key is invalid.
    """
    parts, position = [], 0
    while True:
        match = _PART.match(key, position)
        if match is None:
            raise InputError(_INVALID_KEY, key=key)
        parts.append(match["bare"] if match["quoted"] is None else _unquote(match["quoted"], key))
        position = match.end()
        if position == len(key):
            return parts
        if key[position] != ".":
            raise InputError(_INVALID_KEY, key=key)
        position += 1


def _unquote(text: str, key: str) -> str:
    try:
        return str(tomllib.loads(f"name = {text}")["name"])
    except tomllib.TOMLDecodeError:
        raise InputError(_INVALID_KEY, key=key) from None


def join_path(parts: Iterable[str]) -> str:
    """Join parts to a full key."""
    return ".".join(part if _PLAIN.fullmatch(part) else quote_toml(part) for part in parts)


def quote_toml(text: str) -> str:
    """Return a TOML string in double quotes."""
    return json_text(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def toml_key(name: str) -> str:
    """Return a name as a TOML key, in quotes if necessary."""
    return name if _BARE.fullmatch(name) else quote_toml(name)


def toml_value(value: Any) -> str:
    """Return a value as TOML in one line, with numbers that can be read back exactly."""
    if isinstance(value, Mapping):
        pairs = (f"{toml_key(name)} = {toml_value(inner)}" for name, inner in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, float):
        return repr(value)
    return quote_toml(value) if isinstance(value, str) else json_text(value)


def split_setting(word: str) -> tuple[str, str] | None:
    """Split `KEY=VALUE`; quoted names may contain `=`. Return None for other words."""
    match = _SETTING.fullmatch(word)
    return None if match is None else (match["key"], match["value"])


def split_index(part: str) -> tuple[str, int | None]:
    """Split a part such as `position[2]` into name and index; None without index."""
    match = _INDEXED.fullmatch(part)
    return (part, None) if match is None else (match["name"], int(match["index"]))


def is_pattern(name: str) -> bool:
    """Return whether a name is a pattern, such as `motor*` or `leg_?`."""
    return "*" in name or "?" in name


def expand_names(
    tables: Mapping[str, T], kind: str, names: Collection[str], key: str
) -> list[tuple[str, str, T]]:
    """Expand patterns such as `motor*` to names; tables of single names come last.

    Args:
        tables: Tables by name or pattern.
        kind: Kind of the names, for messages.
        names: All existing names.
        key: Full key of the tables.

    Returns:
        Full key, name and table; later tables have precedence.

    Raises:
        InputError: A name does not exist, or no name matches a pattern.
    """
    rows: list[tuple[str, str, T]] = []
    for name in sorted(tables, key=lambda name: name in names):
        matching = [name] if name in names else []
        at = f"{key}.{name}"
        if not matching and is_pattern(name):
            matching = [each for each in names if fnmatchcase(each, name)]
            if not matching:
                raise InputError(f"no {kind} matches; known: {', '.join(names)}", key=at)
        if not matching:
            raise UnknownNameError(kind, name, names, key=at)
        rows += [(at, each, tables[name]) for each in matching]
    return rows


def set_value(data: dict[str, Any], key: str, value: Any, file: Path) -> None:
    """Set a value by its full key; missing tables are created.

    If the key adds a name to a single number for all names, the number remains the value of all
    other names. A pattern such as `muscles.motor*.f_max` also changes existing tables that match.

    Args:
        data: The settings; changed in place.
        value: The value; copied.
        file: File of the settings, for messages.

    Raises:
        PathError: The key contains a value that is not a table, or an index beyond a list.
    """
    _set(data, split_path(key), key, value, file)


def _set(data: dict[str, Any], path: list[str], key: str, value: Any, file: Path) -> None:
    part, *rest = path
    if not rest:
        _set_last(data, part, key, value, file)
        return
    if is_pattern(part):
        for name, table in data.items():
            if name != part and fnmatchcase(name, part) and isinstance(table, dict):
                _set(table, rest, key, value, file)
    inner = _row(data, part, key, file)
    if inner is None:
        inner = data.setdefault(part, {})
    if isinstance(inner, int | float) and not isinstance(inner, bool):
        inner = data[part] = {EVERY_OTHER: inner}
    if not isinstance(inner, dict):
        raise PathError(f"{part!r} is not a table", file=file, key=key)
    _set(inner, rest, key, value, file)


def _set_last(data: dict[str, Any], part: str, key: str, value: Any, file: Path) -> None:
    name, index = split_index(part)
    elements = data.get(name)
    if index is None or not isinstance(elements, list):
        data[part] = copy.deepcopy(value)
        return
    if index >= len(elements):
        raise PathError(f"{name!r} has {len(elements)} elements", file=file, key=key)
    elements[index] = copy.deepcopy(value)


def _row(data: Mapping[str, Any], part: str, key: str, file: Path) -> Any:
    """Return the row of an array of tables for a part such as `objects[0]`; otherwise None."""
    name, index = split_index(part)
    rows = data.get(name)
    if index is None or not isinstance(rows, list):
        return None
    if index >= len(rows):
        raise PathError(f"{name!r} has {len(rows)} elements", file=file, key=key)
    return rows[index]
