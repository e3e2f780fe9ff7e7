"""Files of pre-shared keys, with which frames are signed."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import read_file

MIN_BYTES = 16
_MAX_BYTES = 4096


def read_key(file: str | Path) -> bytes:
    """Return the key in a file: all of its bytes.

    Raises:
        InputError: It cannot be read, or holds too few or too many bytes for a key.
    """
    key = read_file(Path(file), _MAX_BYTES)
    if len(key) < MIN_BYTES:
        what = f"holds {len(key)} bytes; a key needs at least {MIN_BYTES}, such as"
        raise InputError(f"{what} `head -c 32 /dev/urandom > key.bin` makes", file=file)
    return key


def key_warning(file: Path, name: str) -> str | None:
    """Return a warning about the permissions of a key file, or None.

    Args:
        file: The file.
        name: What the warning calls it: where the warning is kept, no path to a key should be.
    """
    if os.name != "posix":
        return None
    try:
        mode = file.stat().st_mode
    except OSError:
        return None
    if mode & (stat.S_IRGRP | stat.S_IROTH):
        return f"{name}: others can read this key; its file needs chmod 600"
    return None
