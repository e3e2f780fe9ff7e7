"""Zip archives: byte-for-byte reproducible writing, defensive unpacking."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import BinaryIO

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.files import file_error, open_file, read_file, write_files

_LEVEL = 4  # a library is packed in half the time of the default's, 2 % larger
_PACKED = (".fmu", ".zip", ".png")
_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_READABLE = 0o644 << 16
_DIRECTORY_END = struct.Struct("<4s4H2LH")
_LARGE_DIRECTORY = b"PK\x06\x07"
_MAX_COMMENT = 2**16
_MAX_NAME = 1000


def archive_bytes(files: Mapping[str, bytes]) -> bytes:
    """Return the contents of an archive, of contents by path below its root."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(_entry(name), files[name], compresslevel=_LEVEL)
    return memory.getvalue()


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write aside and move into place, so that no half-written file is ever seen.

    Raises:
        InputError: It cannot be written.
        MachineError: There is no room.
    """
    write_files(path.parent, {path.name: archive_bytes(files)})


def contents_of(source: bytes | Path) -> bytes:
    """Contents as they are, or those of a file.

    Raises:
        InputError: The file cannot be read.
    """
    if isinstance(source, bytes):
        return source
    return read_file(source, limits.ARCHIVE)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST_TIME)
    entry.create_system = _UNIX
    entry.external_attr = _READABLE
    packed = name.endswith(_PACKED)
    entry.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
    return entry


def unpack_archive(
    path: Path, folder: Path, kind: str, contents: str, *, without: tuple[str, ...] = ()
) -> Path:
    """Unpack an archive, rejecting names that lead out of the folder.

    Args:
        path: The archive.
        folder: An empty folder.
        kind: What it should be, such as `.ssp`, for messages.
        contents: What it should hold, such as `a system of FMUs`, for messages.
        without: Prefixes of names of files that stay packed.

    Returns:
        The folder.

    Raises:
        InputError: It is no zip archive, or holds what it should not.
    """
    with opened_archive(path, kind) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > limits.UNPACKED:
            raise InputError(f"is larger than {contents} may be", file=path)
        for entry in entries:
            require_inside(entry.filename, path)
        names = (entry.filename for entry in entries)
        archive.extractall(folder, [name for name in names if not name.startswith(without)])
    return folder


@contextlib.contextmanager
def opened_archive(path: Path, kind: str) -> Iterator[zipfile.ZipFile]:
    """An archive opened for reading, whatever it holds.

    Args:
        path: The archive.
        kind: What it should be, such as `.ssp`, for messages.

    Raises:
        InputError: It is no zip archive, is too large, or is damaged if it is read meanwhile.
    """
    try:
        with open_file(path, limits.ARCHIVE) as stream, _archive(stream) as archive:
            yield archive
    except InputError as error:
        if error.file is None:
            error.file = path
        raise
    except MachineError:
        raise
    except Exception as error:  # damage shows in many errors, of zlib and of seeking too
        if isinstance(error, OSError) and isinstance(
            full := file_error(error, "cannot be unpacked", path), MachineError
        ):
            raise full from None
        raise InputError(
            f"is not a valid {kind}: {' '.join(str(error).split())}", file=path
        ) from None


def inner_archive(data: bytes) -> zipfile.ZipFile:
    """Return an archive that stood in another; errors of damage are those of `zipfile`.

    Raises:
        InputError: It is too large.
    """
    return _archive(io.BytesIO(data))


def _archive(stream: BinaryIO) -> zipfile.ZipFile:
    """Return an archive, whose directory is small enough to be read."""
    stream.seek(0, os.SEEK_END)
    length = stream.tell()
    stream.seek(max(0, length - _MAX_COMMENT - 2 * _DIRECTORY_END.size))
    tail = stream.read()
    at = tail.rfind(b"PK\x05\x06")
    if 0 <= at <= len(tail) - _DIRECTORY_END.size:
        size = _DIRECTORY_END.unpack_from(tail, at)[5]
        if size > limits.ARCHIVE_DIRECTORY or _LARGE_DIRECTORY in tail[max(0, at - 20) : at]:
            raise InputError("is an archive of too many files")
    stream.seek(0)
    archive = zipfile.ZipFile(stream)
    if len(archive.infolist()) > limits.ARCHIVE_ENTRIES:
        archive.close()
        raise InputError(f"is an archive of more than {limits.ARCHIVE_ENTRIES} files")
    return archive


def entry_bytes(archive: zipfile.ZipFile, entry: str | zipfile.ZipInfo, largest: int) -> bytes:
    """Return the content of a file in an archive.

    Args:
        archive: The archive.
        entry: The file, or its name.
        largest: So many bytes are taken; more are rejected.

    Raises:
        InputError: It is larger.
        KeyError: There is none.
    """
    info = archive.getinfo(entry) if isinstance(entry, str) else entry
    if info.file_size > largest:
        raise InputError(f"its {info.filename} {limits.too_large(largest)}")
    return archive.read(info)


def require_inside(name: str, path: Path) -> None:
    """Reject a name in an archive that leads out of it, or that no file can have.

    Raises:
        InputError: It does.
    """
    parts = PurePosixPath(name).parts
    if not parts or len(name) > _MAX_NAME:
        what = f"holds a file with a name of {len(name)} characters; 1 to {_MAX_NAME} can be"
        raise InputError(f"{what} unpacked", file=path)
    if name.startswith("/") or "\\" in name or ":" in name or ".." in parts:
        raise InputError(f"holds {name!r}, which leads out of the archive", file=path)
