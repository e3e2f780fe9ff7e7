"""Single output files that replace earlier ones of this package, and no others."""

from __future__ import annotations

import sys
from collections.abc import Collection
from pathlib import Path

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import file_error, is_folder, opened_file, write_files

MARK = "cardsflow"
"""Who has made a picture or a page, where its format says so."""

GENERATOR = f'<meta name="generator" content="{MARK}">'

_FAR = 2**16


def own_place(file: str | Path, suffixes: Collection[str]) -> Path:
    """A place for a file that is new, or that we have written before: asked for before the work.

    Raises:
        InputError: The name does not fit, or somebody else's file is there.
    """
    file = Path(file)
    if file.suffix.lower() not in suffixes:
        raise InputError(f"must end in {' or '.join(suffixes)}", file=file)
    if is_folder(file):
        raise InputError("is a folder; name a file", file=file)
    if not _is_free(file):
        what = "is there already, and is not of cardsflow; choose another name"
        raise InputError(what, file=file)
    return file


def write_own(place: Path, content: str | bytes) -> Path:
    """Write a file.

    Args:
        place: From `own_place`.
        content: The content; it holds `MARK`.

    Raises:
        InputError: It cannot be written.
    """
    return write_files(place.parent, {place.name: content})[0]


def _is_free(file: Path) -> bool:
    """Whether there is nothing, or something of ours."""
    try:
        if not file.exists():
            return True
        with opened_file(file, sys.maxsize) as stream:
            head = stream.read(_FAR)
            stream.seek(max(file.stat().st_size - _FAR, 0))
            return not head or MARK.encode() in head or MARK.encode() in stream.read(_FAR)
    except (OSError, ValueError) as error:
        raise file_error(error, "cannot be written", file) from None
