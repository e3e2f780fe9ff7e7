"""Reading files of settings: TOML, or JSON by the suffix."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import read_file

_MAX_BYTES = 64 * 2**20


def read_settings(file: Path) -> dict[str, Any]:
    """A file's content as plain data.

    Args:
        file: A .toml, or an experiment.json of an FMU.

    Raises:
        InputError: It cannot be read.
    """
    try:
        text = read_file(file, _MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    try:
        data = json.loads(text) if file.suffix == ".json" else tomllib.loads(text)
    except ValueError as error:
        raise InputError(" ".join(str(error).split()), file=file) from None
    except RecursionError:
        raise InputError("is nested too deeply", file=file) from None
    if not isinstance(data, dict):
        raise InputError("must hold a table", file=file)
    return data
