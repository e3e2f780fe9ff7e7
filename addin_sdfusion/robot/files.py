"""Reading of untrusted files, and atomic writing of several."""

from __future__ import annotations

import contextlib
import os
import re
import stat
from collections.abc import Mapping
from pathlib import Path

from .errors import InputError

_ASIDE = ".cardsflow.tmp"
_LEFTOVER = re.compile(r"\..+\.\d+\.cardsflow\.tmp")


def read_file(file: Path, largest: int) -> bytes:
    """The content of a regular file.

    Args:
        file: What to read.
        largest: So many bytes are taken; more are refused.

    Raises:
        InputError: It is missing, no regular file, too large, or may not be read.
    """
    try:
        info = file.stat()
        if stat.S_ISDIR(info.st_mode):
            raise InputError("is a folder, not a file", file=file)
        if not stat.S_ISREG(info.st_mode):
            raise InputError("is not a regular file", file=file)
        if info.st_size > largest:
            most = f"{largest >> 20} MiB" if largest >> 20 else f"{largest} bytes"
            raise InputError(f"is larger than {most}", file=file)
        with file.open("rb") as stream:
            return stream.read(largest)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", file=file) from error


def is_folder(path: Path) -> bool:
    """Whether there is a folder; a path that nothing can have is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def write_files(folder: str | Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write files into a folder: all of them aside first, then each into place.

    Args:
        folder: Where to; made if it does not exist.
        contents: The content of each file, by its name; text becomes UTF-8.

    Returns:
        The files, in the order given.

    Raises:
        InputError: The folder cannot be made or written.
    """
    folder = Path(folder)
    waiting = {folder / name: folder / f".{name}.{os.getpid()}{_ASIDE}" for name in contents}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for content, aside in zip(contents.values(), waiting.values(), strict=True):
            aside.write_bytes(content if isinstance(content, bytes) else content.encode())
        for file, aside in waiting.items():
            aside.replace(file)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be written: {reason}", file=folder) from error
    finally:
        for aside in waiting.values():
            with contextlib.suppress(OSError, ValueError):
                aside.unlink(missing_ok=True)
    return list(waiting)


def remove_leftovers(folder: Path) -> None:
    """Remove what `write_files` of a killed process has left in a folder that no other writes."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _LEFTOVER.fullmatch(entry.name):
                Path(entry).unlink()
