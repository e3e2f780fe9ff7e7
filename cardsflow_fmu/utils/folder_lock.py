"""Locks on folders, so that only one program at a time writes into a folder.

The operating system locks a file in the folder. It releases the lock when the process ends, even if
the process is killed.
"""

from __future__ import annotations

import contextlib
import datetime
import os
import socket
import sys
from collections.abc import Iterator
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error, remove_leftovers

LOCK = ".cardsflow.lock"
"""Name of the lock file; it contains a description of the lock's owner."""

_MAX_DESCRIPTION = 300
_EXISTS = "already exists; choose a new folder"


class FolderLock:
    """Lock on an existing folder, until `release`.

    Raises:
        InputError: Another program has the lock, or the folder cannot be written.
    """

    def __init__(self, folder: Path, work: str) -> None:
        self._file = folder / LOCK
        try:
            self._descriptor = _open_locked(self._file)
        except BlockingIOError:
            problem = f"another program uses this folder{_owner(self._file)}; wait until it ends"
            raise InputError(f"{problem}, or choose another folder", file=folder) from None
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", folder) from None
        since = datetime.datetime.now().astimezone().isoformat(" ", "seconds")
        owner = f"{work} of process {os.getpid()} on {socket.gethostname()} since {since}\n"
        with contextlib.suppress(OSError):  # on a full disk the lock has no description
            os.ftruncate(self._descriptor, 0)
            os.write(self._descriptor, owner.encode())

    def release(self) -> None:
        """Remove the lock file and release the lock."""
        with contextlib.suppress(OSError):
            self._file.unlink()
        with contextlib.suppress(OSError):
            os.close(self._descriptor)


@contextlib.contextmanager
def lock_folder(folder: Path, work: str) -> Iterator[None]:
    """Lock a folder, as a context; arguments and errors as for `FolderLock`."""
    lock = FolderLock(folder, work)
    try:
        yield
    finally:
        lock.release()


@contextlib.contextmanager
def create_folder(folder: Path, work: str) -> Iterator[None]:
    """Create a folder if it does not exist and lock it, as a context.

    If the folder is created and remains empty, it is removed at the end.

    Raises:
        InputError: As for `FolderLock`, or the folder cannot be created.
        MachineError: The disk is full.
    """
    missing: list[Path] = []
    try:
        try:
            missing = [path for path in (folder, *folder.parents) if not path.exists()]
            for path in reversed(missing):
                path.mkdir(exist_ok=True)
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", folder) from None
        with lock_folder(folder, work):
            remove_leftovers(folder)
            yield
    finally:
        with contextlib.suppress(OSError, ValueError):
            for path in missing:
                path.rmdir()


@contextlib.contextmanager
def create_new_folder(folder: Path, work: str) -> Iterator[None]:
    """Create and lock a folder, as `create_folder`, and reject a folder that is not empty.

    Raises:
        InputError: As for `create_folder`, or the folder is not empty.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(_EXISTS, file=folder)
    with create_folder(folder, work):
        if any(path.name != LOCK for path in folder.iterdir()):
            raise InputError(_EXISTS, file=folder)
        yield


def _open_locked(file: Path) -> int:
    """Open and lock a file and return its descriptor.

    If the previous owner removed the file after it was opened here, open it again.
    """
    while True:
        descriptor = os.open(file, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o644)
        try:
            _lock(descriptor)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(descriptor), file.stat()):
                    return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        """Lock a byte far beyond the description, so that others can read the description."""
        os.lseek(descriptor, 2**30, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError as error:
            raise BlockingIOError from error
        os.lseek(descriptor, 0, os.SEEK_SET)
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        """Lock the file, or raise BlockingIOError."""
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _owner(file: Path) -> str:
    """Return the description of a lock's owner in parentheses, or an empty string."""
    try:
        with file.open(encoding="utf-8", errors="replace") as stream:
            owner = " ".join(stream.read(_MAX_DESCRIPTION).split())
    except OSError:
        return ""
    return f" ({owner})" if owner else ""
