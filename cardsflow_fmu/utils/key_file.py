"""Files with pre-shared keys, which sign frames."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import read_file

MIN_BYTES = 16
_MAX_BYTES = 4096


def read_key(file: str | Path) -> bytes:
    """Return the key in a file, which consists of all bytes of the file.

    Raises:
        InputError: The file cannot be read, or contains too few or too many bytes for a key.
    """
    key = read_file(Path(file), _MAX_BYTES)
    if len(key) < MIN_BYTES:
        problem = f"contains {len(key)} bytes; a key needs at least {MIN_BYTES}; create one with"
        raise InputError(f"{problem} `head -c 32 /dev/urandom > key.bin`", file=file)
    return key


def key_warning(file: Path, name: str) -> str | None:
    """Return a warning about the permissions of a key file, or None.

    Args:
        name: Name of the key in the warning, since stored warnings should not contain its path.
    """
    if os.name != "posix":
        return None
    try:
        mode = file.stat().st_mode
    except OSError:
        return None
    if mode & (stat.S_IRGRP | stat.S_IROTH):
        return f"{name}: other users can read this key; restrict its file with chmod 600"
    return None
