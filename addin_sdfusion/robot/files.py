"""Reading of untrusted files and atomic writing of files."""

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

_SYSTEM_ERRORS = {
    getattr(errno, name, None)
    for name in ("ENOSPC", "EDQUOT", "EFBIG", "EIO", "EMFILE", "ENFILE", "ENOMEM")
} - {None}
_TEMPORARY_SUFFIX = ".cardsflow.tmp"
_LEFTOVER = re.compile(r"\..+\.\d+\.cardsflow\.tmp")


def read_file(file: Path, largest: int) -> bytes:
    """Return the content of a regular file.

    Args:
        largest: Maximum size, in bytes.

    Raises:
        InputError: The file does not exist, is not a regular file, is too large or is not readable.
    """
    with open_file(file, largest) as stream:
        try:
            return stream.read(os.fstat(stream.fileno()).st_size)  # limits the allocated memory
        except OSError as error:
            raise file_error(error, "cannot be read", file) from error


def open_file(file: Path, largest: int) -> BinaryIO:
    """Open a regular file for reading; arguments and errors as for `read_file`."""
    try:
        if file.is_dir():
            raise InputError("is a folder, not a file", file=file)
        stream = open(file, "rb", opener=_open_nonblocking)  # noqa: SIM115 - the caller closes it
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


def file_error(error: OSError | ValueError, failure: str, file: str | Path) -> CardsflowError:
    """Convert an OSError about a file to a MachineError or an InputError.

    Errors such as a full disk become a MachineError, all others an InputError.

    Args:
        error: Error of the operating system, or ValueError for an invalid path.
        failure: Description of the failure, such as `cannot be written`.
        file: The file or folder.
    """
    number = getattr(error, "errno", None)
    problem = f"{failure}: {getattr(error, 'strerror', None) or error}"
    return (
        MachineError(problem, file) if number in _SYSTEM_ERRORS else InputError(problem, file=file)
    )


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file without waiting for the other end of a pipe."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def is_folder(path: Path) -> bool:
    """Return whether a path is an existing folder; False for an invalid path."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def write_new(file: Path, content: bytes) -> None:
    """Replace a file. An existing symbolic link is removed, not followed."""
    file.unlink(missing_ok=True)
    file.write_bytes(content)


def write_files(folder: str | Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write files into a folder.

    All files are written under temporary names first, then renamed.

    Args:
        folder: Output folder; created if it does not exist.
        contents: Content of each file, by file name. Text is encoded as UTF-8.

    Raises:
        InputError: The folder cannot be created or written.
        MachineError: The disk is full.
    """
    folder = Path(folder)
    waiting = {folder / name: _temporary_file(folder / name) for name in contents}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for content, temporary in zip(contents.values(), waiting.values(), strict=True):
            write_new(temporary, content if isinstance(content, bytes) else content.encode())
        for file, temporary in waiting.items():
            temporary.replace(file)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", folder) from error
    finally:
        for temporary in waiting.values():
            with contextlib.suppress(OSError, ValueError):
                temporary.unlink(missing_ok=True)
    return list(waiting)


@contextlib.contextmanager
def replace_file(file: Path) -> Iterator[BinaryIO]:
    """Open a temporary stream that replaces a file at the end of a successful block.

    After an error the file is unchanged.

    Raises:
        InputError: The folder cannot be created or written.
        MachineError: The disk is full.
    """
    temporary = _temporary_file(file)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        temporary.unlink(missing_ok=True)
        with temporary.open("x+b") as stream:
            yield stream
        temporary.replace(file)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", file) from error
    finally:
        with contextlib.suppress(OSError, ValueError):
            temporary.unlink(missing_ok=True)


def _temporary_file(file: Path) -> Path:
    """Return the temporary name of a file in the same folder; `_LEFTOVER` matches it."""
    return file.parent / f".{file.name}.{os.getpid()}{_TEMPORARY_SUFFIX}"


def remove_leftovers(folder: Path) -> None:
    """Remove temporary files of killed processes from a folder that no other process writes."""
    with contextlib.suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _LEFTOVER.fullmatch(entry.name):
                Path(entry).unlink()
