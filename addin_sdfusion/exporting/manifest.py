"""Manifest of an export: the list of the files that it wrote, kept next to them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from ..robot import limits
from ..robot.errors import InputError
from ..robot.files import read_file
from ..robot.json_text import json_text

MANIFEST = ".cardsflow-export.json"
FORMAT = 1
"""Version of the list; of another one nothing is replaced."""


def digest(content: bytes) -> str:
    """The fingerprint of a file; line ends do not count, as version control may turn them."""
    return hashlib.sha256(content.replace(b"\r\n", b"\n")).hexdigest()


def manifest_text(
    files: Mapping[str, str], contents: Mapping[str, tuple[str, str]] | None = None
) -> str:
    """Return the text of a list.

    Args:
        files: The fingerprint of each file by its path below the folder.
        contents: What the robot holds, for what is otherwise in the next one.
    """
    robot = {"robot": dict(sorted(contents.items()))} if contents else {}
    plain = {"format": FORMAT, "files": dict(sorted(files.items())), **robot}
    return json_text(plain, indent=1, ensure_ascii=False) + "\n"


def read_manifest(folder: Path) -> dict[str, str]:
    """What an earlier export wrote into a folder: fingerprints by path; empty if there was none.

    Raises:
        InputError: The list is damaged, or names a file outside the folder.
    """
    file = folder / MANIFEST
    if not file.exists():
        return {}
    plain = read_json(file)
    if not isinstance(plain, dict) or plain.get("format") != FORMAT:
        raise damaged(file)
    files = plain.get("files")
    if not isinstance(files, dict) or not all(isinstance(mark, str) for mark in files.values()):
        raise damaged(file)
    return {require_inside(path, file): mark for path, mark in files.items()}


def read_contents(folder: Path) -> dict[str, tuple[str, str]] | None:
    """What the robot held that was exported into a folder before; None if that is not known."""
    try:
        plain = read_json(folder / MANIFEST)
    except InputError:
        return None
    robot = plain.get("robot") if isinstance(plain, dict) else None
    if not isinstance(robot, dict):
        return None
    pairs = {name: pair for name, pair in robot.items() if isinstance(pair, list)}
    return {name: (str(pair[0]), str(pair[1])) for name, pair in pairs.items() if len(pair) == 2}


def read_json(file: Path) -> Any:
    """Return the content of one of the export's own files.

    Raises:
        InputError: It cannot be read or is not JSON.
    """
    try:
        return json.loads(read_file(file, limits.JSON).decode())
    except (ValueError, RecursionError):
        raise damaged(file) from None


def require_inside(path: Any, file: Path) -> str:
    """Return a path of a list, if it stays below the folder: a list may come from anywhere.

    Raises:
        InputError: It does not.
    """
    if not isinstance(path, str) or not path or any(sign in path for sign in "\\:\0"):
        raise damaged(file)
    parts = PurePosixPath(path).parts
    if path.startswith("/") or ".." in parts or "/".join(parts) != path:
        raise damaged(file)
    return path


def damaged(file: Path) -> InputError:
    """Return the error for one of the export's own files that is not as it was written."""
    what = "is damaged, so it is not known what an earlier export wrote; export into a new folder"
    return InputError(what, file=file)
