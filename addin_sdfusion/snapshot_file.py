"""Snapshot files in JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .record_schema import record_schema
from .robot import limits
from .robot.errors import InputError
from .robot.files import read_file, write_files
from .robot.json_text import json_text
from .robot.records import from_plain, to_plain
from .snapshot import DesignSnapshot

FORMAT = 2
"""Version of the file format. It increases if older readers would misread a new file."""


def file_schema() -> dict[str, Any]:
    """Return the JSON Schema of the file."""
    return {
        "type": "object",
        "properties": {
            "$schema": {"type": "string"},
            "format": {"const": FORMAT},
            "design": record_schema(DesignSnapshot),
        },
        "required": ["format", "design"],
        "additionalProperties": False,
    }


def snapshot_text(snapshot: DesignSnapshot) -> str:
    """Return the text of a snapshot's file."""
    plain = {"format": FORMAT, "design": to_plain(snapshot)}
    return json_text(plain, indent=1, sort_keys=True) + "\n"


def write_snapshot(snapshot: DesignSnapshot, file: str | Path) -> Path:
    """Write a snapshot as JSON.

    Raises:
        InputError: The file cannot be written.
    """
    file, text = Path(file), snapshot_text(snapshot).encode()
    if len(text) > limits.SNAPSHOT:
        problem = f"{limits.too_large(limits.SNAPSHOT)}, and could not be read; use coarser meshes"
        raise InputError(problem, file=file)
    return write_files(file.parent, {file.name: text})[0]


def read_snapshot(file: str | Path) -> DesignSnapshot:
    """Read a snapshot from JSON.

    Raises:
        InputError: The file cannot be read or is not a snapshot; the message names the key.
    """
    file = Path(file)
    try:
        text = read_file(file, limits.SNAPSHOT)
        if text.count(b",") > limits.SNAPSHOT_VALUES:
            problem = f"holds more than {limits.SNAPSHOT_VALUES} values"
            raise InputError(problem, file=file)
        plain = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", file=file) from None
    if not isinstance(plain, dict) or plain.keys() - {"$schema"} != {"format", "design"}:
        raise InputError("is not a design snapshot; see docs/reference/snapshot.md", file=file)
    if plain["format"] != FORMAT:
        problem = f"has format {plain['format']!r}, this version reads {FORMAT}"
        raise InputError(problem, file=file, key="format")
    try:
        return from_plain(DesignSnapshot, plain["design"], "design")
    except InputError as error:
        raise InputError(error.problem, file=file, key=error.key) from None
