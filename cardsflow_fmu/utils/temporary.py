"""Temporary folders, removed after use; folders of killed processes are removed later."""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error

from .folder_lock import LOCK, FolderLock

_PREFIX = "cardsflow_tmp_"
_ATTEMPTS = 10


class TemporaryFolder:
    """A new folder, locked while it is in use.

    Attributes:
        path: The folder, which contains a lock file.
    """

    def __init__(self) -> None:
        _remove_abandoned()
        for attempt in range(_ATTEMPTS):
            try:
                self.path = Path(tempfile.mkdtemp(prefix=_PREFIX))
                self._lock = FolderLock(self.path, "temporary files")
                return
            except InputError:  # another process removed it as abandoned before it was locked
                if attempt == _ATTEMPTS - 1:
                    raise
            except OSError as error:
                place = tempfile.gettempdir() if error.filename is None else error.filename
                raise file_error(error, "cannot create a temporary folder", place) from None

    def remove(self) -> None:
        """Remove the folder and its contents."""
        shutil.rmtree(self.path, ignore_errors=True)
        self._lock.release()


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """Create a temporary folder, as a context, and remove it at the end."""
    folder = TemporaryFolder()
    try:
        yield folder.path
    finally:
        folder.remove()


@functools.cache
def _remove_abandoned() -> None:
    """Remove unlocked temporary folders of this user, once per process."""
    with contextlib.suppress(OSError), os.scandir(tempfile.gettempdir()) as entries:
        for entry in entries:
            if entry.name.startswith(_PREFIX) and _is_own_folder(entry):
                _remove_unlocked(Path(entry.path))


def _is_own_folder(entry: os.DirEntry[str]) -> bool:
    status = entry.stat(follow_symlinks=False)
    is_own = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    return is_own and stat.S_ISDIR(status.st_mode)


def _remove_unlocked(folder: Path) -> None:
    if not (folder / LOCK).is_file():  # the process was killed before the lock; folder is empty
        with contextlib.suppress(OSError):
            folder.rmdir()
        return
    with contextlib.suppress(InputError):
        lock = FolderLock(folder, "removal")
        shutil.rmtree(folder, ignore_errors=True)
        lock.release()
