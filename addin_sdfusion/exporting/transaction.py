"""Transaction of file moves: all are done or none, however the work ends.

The moves are written down first. An error undoes those that were done; after a crash `recover`
does, when the folder is next written to.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Sequence
from pathlib import Path

from .manifest import damaged, read_json, require_inside

JOURNAL = "moves.json"

Move = tuple[str, str]
"""From where to where, below the folder; nothing stands there yet."""


def swap(folder: Path, part: Path, moves: Sequence[Move]) -> None:
    """Do moves one after another; if one fails, all are undone.

    Args:
        folder: What the moves are below.
        part: The folder, on the same drive, that holds the journal meanwhile.
        moves: In the order in which they are to be done.

    Raises:
        OSError: A file could not be moved; everything is as it was.
    """
    journal = part / JOURNAL
    aside = part / f"{JOURNAL}.tmp"  # half a journal would be worse than none
    aside.write_text(json.dumps(moves), encoding="utf-8")
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
    """Undo the moves of a swap that a crash has cut short; nothing if there was none.

    Args:
        folder: What the moves were below.
        part: The folder that held the journal.

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
    moves = [(require_inside(a, journal), require_inside(b, journal)) for a, b in plain]
    _undo(folder, moves)
    journal.unlink()


def _undo(folder: Path, moves: Sequence[Move]) -> None:
    """Undo the moves that were done: of these the target is there and the source is not."""
    for source, target in reversed(moves):
        if (folder / target).exists() and not (folder / source).exists():
            _move(folder / target, folder / source)
        remove_empty(folder, target)


def remove_empty(folder: Path, path: str) -> None:
    """Remove the folders of a file that is gone, if nothing else is in them.

    Args:
        folder: What stays.
        path: The file's path below it.
    """
    for parent in Path(path).parents[:-1]:
        try:
            (folder / parent).rmdir()
        except OSError:
            return


def _move(source: Path, target: Path) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    source.replace(target)
