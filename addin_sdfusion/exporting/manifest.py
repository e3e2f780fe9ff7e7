"""Manifest of an export: a list of the exported files in the robot folder."""

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
"""Version of the manifest; files of other versions are not replaced."""


def digest(content: bytes) -> str:
    """Return the fingerprint of a file, ignoring line endings, which version control may change."""
    return hashlib.sha256(content.replace(b"\r\n", b"\n")).hexdigest()


def manifest_text(
    files: Mapping[str, str], contents: Mapping[str, tuple[str, str]] | None = None
) -> str:
    """Return the text of a manifest.

    Args:
        files: Fingerprint of each file, by path relative to the folder.
        contents: Description of the robot, for the list of changes of the next export.
    """
    robot = {"robot": dict(sorted(contents.items()))} if contents else {}
    plain = {"format": FORMAT, "files": dict(sorted(files.items())), **robot}
    return json_text(plain, indent=1, ensure_ascii=False) + "\n"


def read_manifest(folder: Path) -> dict[str, str]:
    """Return the fingerprints of the files of an earlier export, by path; empty if there is none.

    Raises:
        InputError: The manifest is damaged, or contains a file outside the folder.
    """
    file = folder / MANIFEST
    if not file.exists():
        return {}
    plain = read_json(file)
    if not isinstance(plain, dict) or plain.get("format") != FORMAT:
        raise damaged_file_error(file)
    files = plain.get("files")
    if not isinstance(files, dict) or not all(isinstance(mark, str) for mark in files.values()):
        raise damaged_file_error(file)
    return {require_inside(path, file): mark for path, mark in files.items()}


def read_contents(folder: Path) -> dict[str, tuple[str, str]] | None:
    """Return the description of the robot of an earlier export; None if unknown."""
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
    """Return the content of a JSON file of the exporter.

    Raises:
        InputError: The file cannot be read or is not JSON.
    """
    try:
        return json.loads(read_file(file, limits.JSON).decode())
    except (ValueError, RecursionError):
        raise damaged_file_error(file) from None


def require_inside(path: Any, file: Path) -> str:
    """Return a path of a manifest if it is inside the folder, since manifests are untrusted.

    Raises:
        InputError: The path is outside the folder.
    """
    if not isinstance(path, str) or not path or any(sign in path for sign in "\\:\0"):
        raise damaged_file_error(file)
    parts = PurePosixPath(path).parts
    if path.startswith("/") or ".." in parts or "/".join(parts) != path:
        raise damaged_file_error(file)
    return path


def damaged_file_error(file: Path) -> InputError:
    """Return the error for a damaged file of the exporter."""
    problem = "is damaged, so the files of the earlier export are unknown; export into a new folder"
    return InputError(problem, file=file)
