"""Reader of settings files: TOML, or JSON by suffix."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file

MAX_INTEGER = 2**63
TOO_LONG = "must be within 64 bits"
_MAX_DEPTH = 50
_TOO_DEEP = "is nested too deeply"
_DOTTED = re.compile(
    rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{_MAX_DEPTH}}}""", re.ASCII
)
"""A key with too many dotted names, which would take tomllib minutes."""


def read_settings(file: Path) -> dict[str, Any]:
    """Read a file as plain data.

    Raises:
        InputError: The file cannot be read.
    """
    is_json = file.suffix == ".json"
    try:
        text = read_file(file, limits.JSON if is_json else limits.SETTINGS).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    if not is_json and _DOTTED.search(text):
        raise InputError(_TOO_DEEP, file=file)
    try:
        data = json.loads(text) if is_json else tomllib.loads(text)
    except ValueError as error:
        raise InputError(" ".join(str(error).split()), file=file) from None
    except RecursionError:
        raise InputError(_TOO_DEEP, file=file) from None
    if not isinstance(data, dict):
        raise InputError("must contain a table", file=file)
    require_sizes(data, file)
    return data


def require_sizes(data: Any, file: Path | None, key: str = "", depth: int = 0) -> None:
    """Check that integers fit into 64 bits and that the nesting depth is limited.

    Raises:
        InputError: An integer is too large, or the nesting is too deep.
    """
    if depth > _MAX_DEPTH:
        raise InputError(_TOO_DEEP, file=file)
    if isinstance(data, dict):
        for name, inner in data.items():
            require_sizes(inner, file, f"{key}.{name}" if key else str(name), depth + 1)
    elif isinstance(data, list):
        for k, inner in enumerate(data):
            require_sizes(inner, file, f"{key}[{k}]", depth + 1)
    elif isinstance(data, int) and abs(data) > MAX_INTEGER:
        raise InputError(TOO_LONG, file=file, key=key or None)
