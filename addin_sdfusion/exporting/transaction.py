"""Transaction of file moves: all are done or none, however the work ends.

The moves are written to a journal first. An error undoes those that were done; after a crash
`recover` does, when the folder is next written to.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from pathlib import Path

from ..robot.json_text import json_text
from .manifest import damaged, read_json, require_inside

JOURNAL = "moves.json"

Move = tuple[str, str]
"""From where to where, below the folder; the target does not exist yet."""


def move_all(folder: Path, part: Path, moves: Sequence[Move]) -> None:
    """Do moves below a folder one after another; if one fails, all are undone.

    Args:
        folder: What the moves are below.
        part: The folder, on the same drive, that holds the journal meanwhile.
        moves: In order.

    Raises:
        OSError: A file could not be moved; everything is as it was.
    """
    journal = part / JOURNAL
    aside = part / f"{JOURNAL}.tmp"  # half a journal would be worse than none
    aside.write_text(json_text(moves), encoding="utf-8")
    aside.replace(journal)
    try:
        for source, target in moves:
            _move(folder / source, folder / target)
        journal.unlink()  # from here on the new files count
    except BaseException:
        _undo(folder, moves)
        with contextlib.suppress(OSError):
            journal.unlink(missing_ok=True)
        raise


def recover(folder: Path, part: Path) -> None:
    """Undo the moves that a crash has cut short, if the part folder holds their journal.

    Raises:
        InputError: The journal is damaged.
        OSError: A file could not be moved back.
    """
    journal = part / JOURNAL
    if not journal.exists():
        return
    plain = read_json(journal)
    if not isinstance(plain, list) or not all(isinstance(m, list) and len(m) == 2 for m in plain):
        raise damaged(journal)
    _undo(folder, [(require_inside(a, journal), require_inside(b, journal)) for a, b in plain])
    journal.unlink()


def _undo(folder: Path, moves: Sequence[Move]) -> None:
    """Undo the moves that were done: their target is there and their source is not."""
    for source, target in reversed(moves):
        if (folder / target).exists() and not (folder / source).exists():
            _move(folder / target, folder / source)
        remove_empty(folder, target)


def remove_empty(folder: Path, path: str) -> None:
    """Remove the folders of a file that is gone, below a folder, if nothing else is in them."""
    with contextlib.suppress(OSError):
        for parent in Path(path).parents[:-1]:
            (folder / parent).rmdir()


def _move(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    source.replace(target)
