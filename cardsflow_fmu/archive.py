"""Zip archives that are byte for byte the same for the same contents."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from pathlib import Path

from addin_sdfusion.robot import InputError

_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_READABLE = 0o644 << 16


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write aside and move into place, so that nobody sees half a file.

    Args:
        path: The archive.
        files: Contents by path below its root.

    Raises:
        InputError: It cannot be written.
    """
    aside = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(aside, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                archive.writestr(_entry(name), files[name])
        aside.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=path) from None
    finally:
        aside.unlink(missing_ok=True)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST_TIME)
    entry.create_system = _UNIX
    entry.external_attr = _READABLE
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry
