"""Full keys of settings, such as `controller.kp.joint_1` or `start.y[2]`, and setting by them."""

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
"""In a table by name: all names that it does not name."""

T = TypeVar("T")

_QUOTED = r""""(?:[^"\\]|\\.)*"|'[^']*'"""
_PART = re.compile(rf"""(?P<quoted>{_QUOTED})|(?P<bare>[^."'][^."]*)""")
_SETTING = re.compile(rf"""(?P<key>(?>{_QUOTED}|[^."'=][^.=]*|\.)+)=(?P<value>.*)""", re.DOTALL)
_PLAIN = re.compile(r"""[^\s."'=\x00-\x1f\x7f][^."=\x00-\x1f\x7f]*""")
_NO_PATH = """is not names with dots between, quoted as in TOML where they hold dots or quotes"""
_INDEXED = re.compile(r"(?P<name>.+)\[(?P<index>[0-9]{1,9})\]")


class PathError(InputError):
    """A key leads through what is no table, or past the end of a row."""


def split_path(key: str) -> list[str]:
    """The parts of a full key; a name with dots or quotes is quoted: `controller.kp."hand.x"`.

    Args:
        key: The full key; quotes are as in TOML, "..." with escapes and '...' without.

    Raises:
        InputError: It is not parts with dots between.
    """
    parts, position = [], 0
    while True:
        match = _PART.match(key, position)
        if match is None:
            raise InputError(_NO_PATH, key=key)
        parts.append(match["bare"] if match["quoted"] is None else _unquoted(match["quoted"], key))
        position = match.end()
        if position == len(key):
            return parts
        if key[position] != ".":
            raise InputError(_NO_PATH, key=key)
        position += 1


def _unquoted(text: str, key: str) -> str:
    try:
        return str(tomllib.loads(f"name = {text}")["name"])
    except tomllib.TOMLDecodeError:
        raise InputError(_NO_PATH, key=key) from None


def join_path(parts: Iterable[str]) -> str:
    """The full key of parts."""
    return ".".join(part if _PLAIN.fullmatch(part) else quoted(part) for part in parts)


def quoted(text: str) -> str:
    """A text as TOML has it, in double quotes."""
    return json_text(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def split_setting(word: str) -> tuple[str, str] | None:
    """Key and value of a word `KEY=VALUE`, where quoted names may hold `=`; None of others."""
    match = _SETTING.fullmatch(word)
    return None if match is None else (match["key"], match["value"])


def indexed(part: str) -> tuple[str, int | None]:
    """Name and index of a part such as `position[2]`; no index where there is none."""
    match = _INDEXED.fullmatch(part)
    return (part, None) if match is None else (match["name"], int(match["index"]))


def is_pattern(name: str) -> bool:
    """Whether a name is for all that it fits, as `motor*` and `leg_?` are."""
    return "*" in name or "?" in name


def by_name(
    tables: Mapping[str, T], kind: str, names: Collection[str], key: str
) -> list[tuple[str, str, T]]:
    """Tables for single names: first those of patterns such as `motor*`, then those of one name.

    Args:
        tables: By name or pattern.
        kind: What is named, for messages.
        names: All there are.
        key: The full key of the tables.

    Returns:
        Full key, name and table, in the order in which they count.

    Raises:
        InputError: There is no such name, or none that fits a pattern.
    """
    found: list[tuple[str, str, T]] = []
    for name in sorted(tables, key=lambda name: name in names):
        own = [name] if name in names else []
        at = f"{key}.{name}"
        if not own and is_pattern(name):
            own = [each for each in names if fnmatchcase(each, name)]
            if not own:
                raise InputError(f"no {kind} fits it (known: {', '.join(names)})", key=at)
        if not own:
            raise UnknownNameError(kind, name, names, key=at)
        found += [(at, each, tables[name]) for each in own]
    return found


def set_value(data: dict[str, Any], key: str, value: Any, file: Path) -> None:
    """Set a value by its full key, making tables on the way.

    Below one number for all names, the number becomes that of every other name. A pattern such as
    `muscles.motor*.f_max` holds for the tables that fit it, too.

    Args:
        data: The settings; changed.
        key: The full key.
        value: The value; copied.
        file: Where the settings come from, for the message.

    Raises:
        PathError: The key leads through what is no table, or past the end of a list.
    """
    _set(data, split_path(key), key, value, file)


def _set(data: dict[str, Any], path: list[str], key: str, value: Any, file: Path) -> None:
    part, *rest = path
    if not rest:
        _set_last(data, part, key, value, file)
        return
    if is_pattern(part):
        for name, own in data.items():
            if name != part and fnmatchcase(name, part) and isinstance(own, dict):
                _set(own, rest, key, value, file)
    inner = _row(data, part, key, file)
    if inner is None:
        inner = data.setdefault(part, {})
    if isinstance(inner, int | float) and not isinstance(inner, bool):
        inner = data[part] = {EVERY_OTHER: inner}
    if not isinstance(inner, dict):
        raise PathError(f"{part!r} is not a table", file=file, key=key)
    _set(inner, rest, key, value, file)


def _set_last(data: dict[str, Any], part: str, key: str, value: Any, file: Path) -> None:
    name, index = indexed(part)
    there = data.get(name)
    if index is None or not isinstance(there, list):
        data[part] = copy.deepcopy(value)
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
