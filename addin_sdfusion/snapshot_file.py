"""Snapshot files: JSON in one format; files in earlier formats are converted to it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from .muscles.stored import stored_muscles, stored_point, stored_surface
from .record_schema import record_schema
from .robot import limits
from .robot.errors import InputError
from .robot.files import read_file, write_files
from .robot.finding import Finding
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
        what = f"{limits.too_large(limits.SNAPSHOT)}, and could not be read; use coarser meshes"
        raise InputError(what, file=file)
    return write_files(file.parent, {file.name: text})[0]


def read_snapshot(file: str | Path) -> DesignSnapshot:
    """Read a snapshot from JSON, of this format or an earlier one.

    Raises:
        InputError: The file cannot be read or is not a snapshot; the message names the key.
    """
    file = Path(file)
    try:
        text = read_file(file, limits.SNAPSHOT)
        if text.count(b",") > limits.SNAPSHOT_VALUES:
            what = f"holds more than {limits.SNAPSHOT_VALUES} values"
            raise InputError(what, file=file)
        plain = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", file=file) from None
    if not isinstance(plain, dict) or plain.keys() - {"$schema"} != {"format", "design"}:
        raise InputError("is not a design snapshot; see docs/reference/snapshot.md", file=file)
    if plain["format"] not in (1, FORMAT) or type(plain["format"]) is not int:
        what = f"has format {plain['format']!r}, this version reads 1 to {FORMAT}"
        raise InputError(what, file=file, key="format")
    try:
        design = plain["design"]
        return from_plain(
            DesignSnapshot,
            design if plain["format"] == FORMAT else _convert_format_1(design),
            "design",
        )
    except InputError as error:
        raise InputError(error.what, file=file, key=error.key) from None


def _convert_format_1(design: Any) -> Any:
    """Return a design converted from format 1, which stored muscles and uses of points as texts.

    Values that are invalid in format 1 are unchanged; the reader rejects them by their key.
    """
    if not isinstance(design, dict):
        return design
    findings: list[Finding] = []
    name = str(design.get("name", ""))
    moved = {key: value for key, value in design.items() if key != "attributes"}
    if "attributes" in design:
        muscles = stored_muscles(_texts(design, "design"), name, findings)
        moved["muscles"] = [to_plain(muscle) for muscle in muscles]
    for key, stored in (("points", stored_point), ("surfaces", stored_surface)):
        if isinstance(design.get(key), list):
            moved[key] = [
                _with_use(item, f"design.{key}[{i}]", stored, findings)
                for i, item in enumerate(design[key])
            ]
    earlier = design.get("findings", [])
    if findings and isinstance(earlier, list):
        moved["findings"] = earlier + [to_plain(finding) for finding in findings]
    return moved


def _with_use(item: Any, where: str, stored: Any, findings: list[Finding]) -> Any:
    if not isinstance(item, dict):
        return item
    name = str(item.get("name", item.get("occurrence", "")))
    use = stored(_texts(item, where), name, findings)
    moved = {key: value for key, value in item.items() if key != "attributes"}
    return moved if use is None else {**moved, "use": to_plain(use)}


def _texts(plain: dict[str, Any], where: str) -> dict[str, str]:
    texts = plain.get("attributes", {})
    if not isinstance(texts, dict) or not all(isinstance(text, str) for text in texts.values()):
        raise InputError("must hold an object of texts", key=f"{where}.attributes")
    return texts
