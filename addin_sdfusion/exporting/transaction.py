"""Transaction of file moves: either all moves are done or none.

The moves are first written to a journal. If a move fails, the completed moves are undone. After a
crash, the next export calls `recover` to undo them.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from ..robot.json_text import json_text
from .manifest import damaged_file_error, read_json, require_inside

JOURNAL = "moves.json"

Move = tuple[str, str]
"""Source and target relative to the folder; the target must not exist."""


def move_all(folder: Path, staging: Path, moves: Sequence[Move]) -> None:
    """Move files inside a folder; if a move fails, undo all moves.

    Args:
        folder: Folder that contains all sources and targets.
        staging: Folder on the same drive in which the journal is written.

    Raises:
        OSError: A file could not be moved; all files are unchanged.
    """
    journal = staging / JOURNAL
    aside = staging / f"{JOURNAL}.tmp"  # the journal must be either complete or missing
    aside.write_text(json_text(moves), encoding="utf-8")
    aside.replace(journal)
    try:
        for source, target in moves:
            _move(folder / source, folder / target)
        journal.unlink()  # the transaction is complete
    except BaseException:
        _undo(folder, moves)
        with contextlib.suppress(OSError):
            journal.unlink(missing_ok=True)
        raise


def recover(folder: Path, staging: Path) -> None:
    """Undo the moves of a transaction that was interrupted by a crash, if a journal exists.

    Raises:
        InputError: The journal is damaged.
        OSError: A file could not be moved back.
    """
    journal = staging / JOURNAL
    if not journal.exists():
        return
    plain = read_json(journal)
    if not isinstance(plain, list) or not all(isinstance(m, list) and len(m) == 2 for m in plain):
        raise damaged_file_error(journal)
    _undo(folder, [(require_inside(a, journal), require_inside(b, journal)) for a, b in plain])
    journal.unlink()


def _undo(folder: Path, moves: Sequence[Move]) -> None:
    """Undo the completed moves, whose target exists and whose source does not."""
    for source, target in reversed(moves):
        if (folder / target).exists() and not (folder / source).exists():
            _move(folder / target, folder / source)
        remove_empty(folder, target)


def remove_empty(folder: Path, path: str) -> None:
    """Remove the parent folders of a removed file, up to a folder, if they are empty."""
    with contextlib.suppress(OSError):
        for parent in Path(path).parents[:-1]:
            (folder / parent).rmdir()


def _move(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    source.replace(target)
