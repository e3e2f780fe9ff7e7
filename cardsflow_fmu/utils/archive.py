"""Zip archives: byte-for-byte reproducible writing, defensive unpacking."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from addin_sdfusion.robot import InputError

_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_READABLE = 0o644 << 16
_MAX_FILES, _MAX_BYTES = 10_000, 2**31


def archive_bytes(files: Mapping[str, bytes]) -> bytes:
    """The contents of an archive, of contents by path below its root."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(_entry(name), files[name])
    return memory.getvalue()


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write aside and move into place, so that no half-written file is ever seen.

    Raises:
        InputError: It cannot be written.
    """
    aside = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        aside.write_bytes(archive_bytes(files))
        aside.replace(path)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}", file=path) from None
    finally:
        aside.unlink(missing_ok=True)


def contents_of(source: bytes | Path) -> bytes:
    """Contents as they are, or those of a file.

    Raises:
        InputError: The file cannot be read.
    """
    if isinstance(source, bytes):
        return source
    try:
        return source.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=source) from None


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST_TIME)
    entry.create_system = _UNIX
    entry.external_attr = _READABLE
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry


def unpack_archive(path: Path, folder: Path, kind: str, contents: str) -> Path:
    """Unpack an archive, refusing names that lead out of the folder.

    Args:
        path: The archive.
        folder: An empty folder.
        kind: What it should be, such as `.ssp`, for messages.
        contents: What it should hold, such as `a system of FMUs`, for messages.

    Returns:
        The folder.

    Raises:
        InputError: It is no zip archive, or holds what it should not.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(path.read_bytes())) as archive:
            entries = archive.infolist()
            if len(entries) > _MAX_FILES or sum(e.file_size for e in entries) > _MAX_BYTES:
                raise InputError(f"is larger than {contents} may be", file=path)
            for entry in entries:
                require_inside(entry.filename, path)
            archive.extractall(folder)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", file=path) from None
    except Exception as error:  # damage shows in many errors, of zlib too
        raise InputError(f"is no {kind}: {' '.join(str(error).split())}", file=path) from None
    return folder


def require_inside(name: str, path: Path) -> None:
    """Refuse a name in an archive that leads out of it.

    Raises:
        InputError: It does.
    """
    parts = PurePosixPath(name).parts
    if name.startswith("/") or "\\" in name or ":" in name or ".." in parts:
        raise InputError(f"holds {name!r}, which leads out of the archive", file=path)
