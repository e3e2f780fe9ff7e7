"""Reading of untrusted files, and atomic writing of several."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

from .errors import CardsflowError, InputError, MachineError
from .limits import too_large

_OF_THE_MACHINE = {
    getattr(errno, name, None)
    for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO", "EMFILE", "ENFILE", "ENOMEM")
} - {None}
_ASIDE = ".cardsflow.tmp"
_LEFTOVER = re.compile(r"\..+\.\d+\.cardsflow\.tmp")


def read_file(file: Path, largest: int) -> bytes:
    """Return the content of a regular file.

    Args:
        file: What to read.
        largest: So many bytes are taken; more are rejected.

    Raises:
        InputError: It is missing, no regular file, too large, or may not be read.
    """
    with opened_file(file, largest) as stream:
        try:
            return stream.read(os.fstat(stream.fileno()).st_size)  # memory for no more is taken
        except OSError as error:
            raise file_error(error, "cannot be read", file) from error


def opened_file(file: Path, largest: int) -> BinaryIO:
    """Return a regular file opened for reading; arguments and errors as for `read_file`."""
    try:
        if file.is_dir():
            raise InputError("is a folder, not a file", file=file)
        stream = open(file, "rb", opener=_open_at_once)  # noqa: SIM115 - the caller closes it
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be read", file) from error
    status = os.fstat(stream.fileno())
    fault = None if stat.S_ISREG(status.st_mode) else "is not a regular file"
    if status.st_size > largest:
        fault = fault or too_large(largest)
    if fault is not None:
        stream.close()
        raise InputError(fault, file=file)
    return stream


def file_error(error: OSError | ValueError, what: str, file: str | Path) -> CardsflowError:
    """Return the error of the system about a file: the user's, or the machine's as of a full disk.

    Args:
        error: What the system says; ValueError of a path that nothing can have.
        what: What did not work, such as `cannot be written`.
        file: The file or folder.
    """
    number = getattr(error, "errno", None)
    what = f"{what}: {getattr(error, 'strerror', None) or error}"
    return MachineError(what, file) if number in _OF_THE_MACHINE else InputError(what, file=file)


def _open_at_once(path: str, flags: int) -> int:
    """Open without waiting for the other end of a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def is_folder(path: Path) -> bool:
    """Return whether there is a folder; a path that nothing can have is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def write_new(file: Path, content: bytes) -> None:
    """Write a file again: what is there, such as a link to another file, goes and is not followed.

    Raises:
        OSError: It cannot be written.
    """
    file.unlink(missing_ok=True)
    file.write_bytes(content)


def write_files(folder: str | Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write files into a folder: all of them aside first, then each into place.

    Args:
        folder: Where to; made if it does not exist.
        contents: The content of each file, by its name; text becomes UTF-8.

    Returns:
        The files, in the order given.

    Raises:
        InputError: The folder cannot be made or written.
        MachineError: There is no room.
    """
    folder = Path(folder)
    waiting = {folder / name: folder / f".{name}.{os.getpid()}{_ASIDE}" for name in contents}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for content, aside in zip(contents.values(), waiting.values(), strict=True):
            write_new(aside, content if isinstance(content, bytes) else content.encode())
        for file, aside in waiting.items():
            aside.replace(file)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", folder) from error
    finally:
        for aside in waiting.values():
            with contextlib.suppress(OSError, ValueError):
                aside.unlink(missing_ok=True)
    return list(waiting)


@contextlib.contextmanager
def replaced_file(file: Path) -> Iterator[BinaryIO]:
    """A stream to a file that takes its place when it is whole; otherwise all stays as it is.

    Raises:
        InputError: The folder cannot be made or written.
        MachineError: There is no room.
    """
    aside = file.parent / f".{file.name}.{os.getpid()}{_ASIDE}"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        aside.unlink(missing_ok=True)
        with aside.open("xb") as stream:
            yield stream
        aside.replace(file)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", file) from error
    finally:
        with contextlib.suppress(OSError, ValueError):
            aside.unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> None:
    """Remove what writing by a killed process has left in a folder that no other writes."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _LEFTOVER.fullmatch(entry.name):
                Path(entry).unlink()
