"""Replacement of an export in its folder: exactly the files of the earlier export.

All other files stay. A file of an earlier export that someone has changed since is kept
as `<file>.bak` next to the new one; `experiment.toml` is the user's to change: theirs stays, and a
new one that differs from what theirs was made of is put next to it as `experiment.new.toml`.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from ..robot.errors import InputError, MachineError
from ..robot.files import file_error
from ..robot.finding import Finding, Subject
from ..robot.finding_builders import warning
from .manifest import MANIFEST, digest, manifest_text, read_manifest
from .safe_names import refused_name
from .transaction import JOURNAL, Move, move_all, recover, remove_empty

EXPERIMENT = "experiment.toml"
NEW_EXPERIMENT = "experiment.new.toml"
PART = ".cardsflow-export.part"
"""The folder in the folder that new files are written to before they take their places."""


def require_folder(folder: str | Path) -> Path:
    """Return the folder to export to.

    Raises:
        InputError: It is not a folder, a link, or has a name that some system rejects.
    """
    folder = Path(os.path.abspath(folder))  # noqa: PTH100 - a link is to be seen, not followed
    if not folder.name:
        raise InputError("is a whole drive; give a folder on it", file=folder)
    if refused_name(folder.name):
        what = "has a name that not every system takes for a folder; give another one"
        raise InputError(what, file=folder)
    if folder.is_symlink():
        raise InputError("is a link; give the folder that it leads to", file=folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("is a file; give a folder", file=folder)
    return folder


@contextmanager
def replacing(folder: str | Path) -> Iterator[Replacement]:
    """New files for a folder, written aside; they take their places with `commit`.

    Whatever happens without it, the folder is as it was.

    Raises:
        InputError: The folder cannot be written, or holds files that would be overwritten.
        MachineError: There is no room.
    """
    folder = require_folder(folder)
    made = [path for path in (folder, *folder.parents) if not path.exists()]  # innermost first
    part = folder / PART
    try:
        _prepare(folder, part)
        yield Replacement(folder, part)
    except OSError as error:
        name = f" ({Path(error.filename).name})" if isinstance(error.filename, str) else ""
        raise file_error(error, f"cannot be written{name}", folder) from error
    except (InputError, MachineError) as error:
        kind = type(error)
        if kind in (InputError, MachineError) and error.file and error.file.is_relative_to(part):
            raise kind(error.what, file=folder) from error
        raise
    finally:
        _tidy(part, made)


def _prepare(folder: Path, part: Path) -> None:
    if part.is_symlink() or part.is_file():
        raise InputError("is in the way; remove it", file=part)
    folder.mkdir(parents=True, exist_ok=True)
    recover(folder, part)
    if part.exists():
        shutil.rmtree(part)
    for name in ("new", "old"):
        (part / name).mkdir(parents=True)


def _tidy(part: Path, made: list[Path]) -> None:
    """Remove what was written aside, and folders that were made for nothing."""
    if (part / JOURNAL).exists():
        return  # neither done nor undone: the next export tries again
    shutil.rmtree(part, ignore_errors=True)
    with suppress(OSError):
        for path in made:
            path.rmdir()


class Replacement:
    """New files, and the folder that they are for.

    Attributes:
        folder: What they are for.
        new: Where to write them.
    """

    def __init__(self, folder: Path, part: Path) -> None:
        self.folder = folder
        self.new = part / "new"
        self._part = part
        self._findings: list[Finding] = []

    def commit(
        self, contents: Mapping[str, tuple[str, str]] | None = None
    ) -> tuple[tuple[Path, ...], list[Finding]]:
        """Put the new files in place of the old ones.

        Args:
            contents: What the robot holds, to be remembered.

        Returns:
            The export's files, also those that have not changed, and which files of the user were
            kept.

        Raises:
            InputError: A file that no export wrote is in the way.
            OSError: A file could not be moved; everything is as it was.
        """
        own = read_manifest(self.folder)
        marks = {path: digest((self.new / path).read_bytes()) for path in _files(self.new)}
        theirs = self._keep_experiment(own, marks)
        stale = [path for path in own if path not in marks and (self.folder / path).exists()]
        old = [*stale, *self._to_replace(own, marks, stale)]
        moves = [move for path in old for move in self._out(path, own[path])]
        if (self.folder / MANIFEST).exists():
            moves.append((MANIFEST, f"{PART}/old/{MANIFEST}"))
        moves += [(f"{PART}/new/{path}", path) for path in _files(self.new)]
        text = manifest_text(marks | theirs, contents)
        (self.new / MANIFEST).write_text(text, encoding="utf-8", newline="\n")
        moves.append((f"{PART}/new/{MANIFEST}", MANIFEST))
        move_all(self.folder, self._part, moves)
        for path in stale:
            remove_empty(self.folder, path)
        return tuple(self.folder / path for path in marks), self._findings

    def _keep_experiment(self, own: dict[str, str], marks: dict[str, str]) -> dict[str, str]:
        """Take an experiment that the user has changed out of the lists.

        Args:
            own: What the earlier export wrote.
            marks: What this one writes.

        Returns:
            What the earlier export's experiment was, to be remembered: as long as a new one is the
            same, the user needs no message.
        """
        theirs = self.folder / EXPERIMENT
        if not theirs.is_file():
            return {}
        present, base, new = digest(theirs.read_bytes()), own.get(EXPERIMENT), marks.get(EXPERIMENT)
        if present in (base, new):
            return {}
        own.pop(EXPERIMENT, None)
        if new is None:
            return {}
        del marks[EXPERIMENT]
        if new == base:
            (self.new / EXPERIMENT).unlink()
        else:
            (self.new / EXPERIMENT).replace(self.new / NEW_EXPERIMENT)
            marks[NEW_EXPERIMENT] = new
            problem = f"you have changed it, so it stays; this export's own is {NEW_EXPERIMENT}"
            self._warn(EXPERIMENT, "experiment-kept", problem)
        return {} if base is None else {EXPERIMENT: base}

    def _to_replace(
        self, own: dict[str, str], marks: dict[str, str], stale: list[str]
    ) -> list[str]:
        """Files to move out of the way; those that stay as they are need not be moved at all."""
        replaced, foreign = [], []
        for path in (*stale, *marks):
            self._require_free(self.folder / path)
        for path in marks:
            target = self.folder / path
            if not target.exists() or self._is_stale(path, stale):
                continue
            if target.read_bytes() == (self.new / path).read_bytes():
                (self.new / path).unlink()
            elif path in own:
                replaced.append(path)
            else:
                foreign.append(path)
        if foreign:
            what = (
                f"holds files that no export wrote: {', '.join(foreign[:5])}"
                f"{', ...' if len(foreign) > 5 else ''}; move them, or export into another folder"
            )
            raise InputError(what, file=self.folder)
        return replaced

    def _is_stale(self, path: str, stale: list[str]) -> bool:
        """Return whether the file there is one that goes: `Arm.stl` where case does not count."""
        alike = [old for old in stale if old.casefold() == path.casefold()]
        return any((self.folder / old).samefile(self.folder / path) for old in alike)

    def _require_free(self, target: Path) -> None:
        """Reject links, which lead out of the folder, and things of another kind in the way."""
        below = target.relative_to(self.folder).parents
        for folder in (self.folder / parent for parent in below):
            if folder.is_symlink() and folder != self.folder:
                raise InputError("is a link; remove it, or export elsewhere", file=folder)
            if folder.exists() and not folder.is_dir():
                raise InputError("is a file where a folder is to be; move it", file=folder)
        if target.is_symlink():
            raise InputError("is a link; remove it, or export elsewhere", file=target)
        if target.is_dir():
            raise InputError("is a folder where a file is to be; move it", file=target)

    def _out(self, path: str, mark: str) -> list[Move]:
        """Return the moves that take away a file of the earlier export."""
        old = f"{PART}/old/{path}"
        if digest((self.folder / path).read_bytes()) == mark:
            return [(path, old)]
        kept = f"{path}.bak"
        number = 2
        while os.path.lexists(self.folder / kept):
            kept = f"{path}.bak{number}"
            number += 1
        problem = f"it was changed after the export before; what it was is now {kept}"
        self._warn(path, "changed-file-kept", problem)
        return [(path, old), (old, kept)]

    def _warn(self, path: str, code: str, problem: str) -> None:
        self._findings.append(warning(Subject("file", path), code, problem))


def _files(folder: Path) -> list[str]:
    """Return the files below a folder, by their paths, in order."""
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
