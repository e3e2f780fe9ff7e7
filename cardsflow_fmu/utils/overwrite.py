"""Output files, which replace only files that CARDSFlow wrote."""

from __future__ import annotations

import sys
from collections.abc import Collection
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error, is_folder, open_file, write_files

MARK = "cardsflow"
"""Name of the program in the metadata of figures and pages."""

GENERATOR = f'<meta name="generator" content="{MARK}">'

NOT_OWN = "already exists and was not written by cardsflow; choose another name or use --overwrite"

_MARK_RANGE = 2**16


def output_file(file: str | Path, suffixes: Collection[str], *, overwrite: bool = False) -> Path:
    """Check that an output file may be written: call it before the work starts.

    Args:
        suffixes: The suffixes that are allowed, such as `.png`.
        overwrite: Whether to replace a file that CARDSFlow did not write.

    Raises:
        InputError: The suffix is not allowed, or the file exists and CARDSFlow did not write it.
    """
    file = Path(file)
    if file.suffix.lower() not in suffixes:
        raise InputError(f"must end in {' or '.join(suffixes)}", file=file)
    if is_folder(file):
        raise InputError("is a folder; name a file", file=file)
    if not overwrite and not _is_replaceable(file):
        raise InputError(NOT_OWN, file=file)
    return file


def write_output(file: Path, content: str | bytes) -> Path:
    """Write a file."""
    return write_files(file.parent, {file.name: content})[0]


def _is_replaceable(file: Path) -> bool:
    """Return whether a file does not exist, is empty, or contains the mark of CARDSFlow."""
    try:
        if not file.exists():
            return True
        with open_file(file, sys.maxsize) as stream:
            head = stream.read(_MARK_RANGE)
            stream.seek(max(file.stat().st_size - _MARK_RANGE, 0))
            return not head or MARK.encode() in head or MARK.encode() in stream.read(_MARK_RANGE)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", file) from None
