"""Zip archives: reproducible writing and safe unpacking of untrusted archives."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import BinaryIO

from addin_sdfusion.robot import InputError, limits
from addin_sdfusion.robot.errors import MachineError
from addin_sdfusion.robot.files import file_error, open_file, read_file, write_files

_LEVEL = 4  # packs a library in half the time of the default level, with 2 % more bytes
_PACKED = (".fmu", ".zip", ".png")
_EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)
_UNIX = 3
_READABLE = 0o644 << 16
_DIRECTORY_END = struct.Struct("<4s4H2LH")
_LARGE_DIRECTORY = b"PK\x06\x07"
_PIECE = 1 << 16
"""Number of bytes that are unpacked at once."""
_MAX_COMMENT = 2**16
_MAX_NAME = 1000


def archive_bytes(files: Mapping[str, bytes], *, compress: bool = True) -> bytes:
    """Return the bytes of an archive; versions of zlib compress to different bytes."""
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        for name in sorted(files):
            packed = not compress or name.endswith(_PACKED)
            kind = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
            archive.writestr(_entry(name), files[name], kind, compresslevel=_LEVEL)
    return memory.getvalue()


def write_archive(path: Path, files: Mapping[str, bytes], *, compress: bool = True) -> Path:
    """Write an archive under a temporary name and rename it, so that it is always complete."""
    return write_files(path.parent, {path.name: archive_bytes(files, compress=compress)})[0]


def read_contents(source: bytes | Path) -> bytes:
    """Return the given bytes, or the content of a file."""
    if isinstance(source, bytes):
        return source
    return read_file(source, limits.ARCHIVE)


def _entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EARLIEST_TIME)
    entry.create_system = _UNIX
    entry.external_attr = _READABLE
    return entry


def unpack_archive(
    path: Path, folder: Path, kind: str, contents: str, *, without: tuple[str, ...] = ()
) -> Path:
    """Unpack an archive and reject paths outside of the folder.

    Args:
        folder: An empty folder.
        kind: Expected kind of archive, such as `.ssp`, for messages.
        contents: Expected contents, such as `a system of FMUs`, for messages.
        without: Prefixes of file names that are not unpacked.

    Raises:
        InputError: The file is not a zip archive, is too large, or contains invalid paths.
    """
    with open_archive(path, kind) as archive:
        entries = archive.infolist()
        if sum(entry.file_size for entry in entries) > limits.UNPACKED:
            raise InputError(f"is too large for {contents}", file=path)
        for entry in entries:
            require_inside(entry.filename, path)
        names = (entry.filename for entry in entries)
        archive.extractall(folder, [name for name in names if not name.startswith(without)])
    return folder


@contextlib.contextmanager
def open_archive(path: Path, kind: str) -> Iterator[zipfile.ZipFile]:
    """Open an archive for reading, as a context; its paths are not checked.

    Raises:
        InputError: The file is not a zip archive, is too large, or is found to be damaged while it
            is read in the context.
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
    except Exception as error:  # damaged archives cause many types of errors, also in zlib
        if isinstance(error, OSError) and isinstance(
            full := file_error(error, "cannot be unpacked", path), MachineError
        ):
            raise full from None
        raise InputError(
            f"is not a valid {kind}: {' '.join(str(error).split())}", file=path
        ) from None


def open_inner_archive(data: bytes) -> zipfile.ZipFile:
    """Open an archive inside of another archive; a damaged archive causes errors of `zipfile`.

    Raises:
        InputError: The archive has too many files.
    """
    return _archive(io.BytesIO(data))


def _archive(stream: BinaryIO) -> zipfile.ZipFile:
    """Open an archive after a check of the size of its directory."""
    stream.seek(0, os.SEEK_END)
    length = stream.tell()
    stream.seek(max(0, length - _MAX_COMMENT - 2 * _DIRECTORY_END.size))
    tail = stream.read()
    at = tail.rfind(b"PK\x05\x06")
    if 0 <= at <= len(tail) - _DIRECTORY_END.size:
        size = _DIRECTORY_END.unpack_from(tail, at)[5]
        if size > limits.ARCHIVE_DIRECTORY or _LARGE_DIRECTORY in tail[max(0, at - 20) : at]:
            raise InputError("is an archive with too many files")
    stream.seek(0)
    archive = zipfile.ZipFile(stream)
    names = archive.namelist()
    if len(names) > limits.ARCHIVE_ENTRIES:
        archive.close()
        raise InputError(f"is an archive with more than {limits.ARCHIVE_ENTRIES} files")
    if len(set(names)) < len(names):
        archive.close()
        twice = max(names, key=Counter(names).__getitem__)
        raise InputError(f"contains two files with the name {twice!r}")
    return archive


def read_entry(archive: zipfile.ZipFile, entry: str | zipfile.ZipInfo, largest: int) -> bytes:
    """Return the content of a file in an archive.

    Args:
        entry: The file, or its name.
        largest: Maximum size, in bytes.

    Raises:
        InputError: The file is too large.
        KeyError: The file does not exist in the archive.
    """
    info = archive.getinfo(entry) if isinstance(entry, str) else entry
    if info.file_size > largest:
        raise InputError(f"its {info.filename} {limits.too_large(largest)}")
    content = bytearray()
    with archive.open(info) as stream:
        # In pieces: one read would unpack a member that is larger than the archive states.
        while piece := stream.read(_PIECE):
            content += piece
    return bytes(content)


def require_inside(name: str, path: Path) -> None:
    """Reject a path outside of an archive, and invalid names.

    Raises:
        InputError: The name is invalid.
    """
    parts = PurePosixPath(name).parts
    if not parts or len(name) > _MAX_NAME:
        problem = f"contains a file name with {len(name)} characters; 1 to {_MAX_NAME} are allowed"
        raise InputError(problem, file=path)
    if name.startswith("/") or "\\" in name or ":" in name or ".." in parts:
        raise InputError(f"contains {name!r}, a path outside of the archive", file=path)
