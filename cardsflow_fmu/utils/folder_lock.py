"""Locks on folders: one program at a time writes into one, and a killed one holds none.

The system keeps the lock, on a file in the folder, and drops it however the process ends.
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
"""Name of the file; it says who holds the lock."""

_MAX_WORDS = 300
_TAKEN = "is there already; choose a new folder"


class FolderLock:
    """Locks a folder that exists, until `release`.

    Args:
        folder: The folder.
        work: What is done in it, such as `run`, for the message of those who come second.

    Raises:
        InputError: Somebody else holds it, or it cannot be written.
    """

    def __init__(self, folder: Path, work: str) -> None:
        self._file = folder / LOCK
        try:
            self._descriptor = _opened(self._file)
        except BlockingIOError:
            what = f"another program is at work in it{_holder(self._file)}; wait for its end, or"
            raise InputError(f"{what} choose another folder", file=folder) from None
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", folder) from None
        since = datetime.datetime.now().astimezone().isoformat(" ", "seconds")
        words = f"{work} of process {os.getpid()} on {socket.gethostname()} since {since}\n"
        with contextlib.suppress(OSError):  # a full disk: locked, without a name
            os.ftruncate(self._descriptor, 0)
            os.write(self._descriptor, words.encode())

    def release(self) -> None:
        """Remove the lock file and release the lock."""
        with contextlib.suppress(OSError):
            self._file.unlink()
        with contextlib.suppress(OSError):
            os.close(self._descriptor)


@contextlib.contextmanager
def locked_folder(folder: Path, work: str) -> Iterator[None]:
    """A folder locked meanwhile; arguments and errors as for `FolderLock`."""
    lock = FolderLock(folder, work)
    try:
        yield
    finally:
        lock.release()


@contextlib.contextmanager
def made_folder(folder: Path, work: str) -> Iterator[None]:
    """A folder made if it is not there, and locked meanwhile; what was made and is empty goes.

    Raises:
        InputError: As for `FolderLock`, or the folder cannot be made.
        MachineError: There is no room.
    """
    missing: list[Path] = []
    try:
        try:
            missing = [path for path in (folder, *folder.parents) if not path.exists()]
            for path in reversed(missing):
                path.mkdir(exist_ok=True)
        except (OSError, ValueError) as error:
            raise file_error(error, "cannot be written", folder) from None
        with locked_folder(folder, work):
            remove_leftovers(folder)
            yield
    finally:
        with contextlib.suppress(OSError, ValueError):
            for path in missing:
                path.rmdir()


@contextlib.contextmanager
def new_folder(folder: Path, work: str) -> Iterator[None]:
    """As `made_folder`, of a folder that is new, or empty, and nobody else's until it is filled.

    Raises:
        InputError: As for `made_folder`, or there is something in it.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(_TAKEN, file=folder)
    with made_folder(folder, work):
        if any(path.name != LOCK for path in folder.iterdir()):
            raise InputError(_TAKEN, file=folder)
        yield


def _opened(file: Path) -> int:
    """Return a descriptor of the locked file.

    Who held it may have removed the file after it was opened here: then there is another one.
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
        """Lock a byte far behind the words, which can be read meanwhile."""
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


def _holder(file: Path) -> str:
    """Who holds a lock, in brackets; nothing if it does not say."""
    try:
        with file.open(encoding="utf-8", errors="replace") as stream:
            words = " ".join(stream.read(_MAX_WORDS).split())
    except OSError:
        return ""
    return f" ({words})" if words else ""
