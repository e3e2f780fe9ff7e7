"""Reading files of settings: TOML, or JSON by the suffix."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.files import read_file


def read_settings(file: Path) -> dict[str, Any]:
    """A file's content as plain data.

    Args:
        file: A .toml, or an experiment.json of an FMU.

    Raises:
        InputError: It cannot be read.
    """
    is_json = file.suffix == ".json"
    try:
        text = read_file(file, limits.JSON if is_json else limits.SETTINGS).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    try:
        data = json.loads(text) if is_json else tomllib.loads(text)
    except ValueError as error:
        raise InputError(" ".join(str(error).split()), file=file) from None
    except RecursionError:
        raise InputError("is nested too deeply", file=file) from None
    if not isinstance(data, dict):
        raise InputError("must hold a table", file=file)
    return data
