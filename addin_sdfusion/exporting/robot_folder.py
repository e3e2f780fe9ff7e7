"""Replacement of the files of an earlier export in its folder.

All other files are unchanged. If the user has changed an exported file, it is kept as `<file>.bak`
next to the new file. A changed `experiment.toml` is not replaced. If the new experiment differs
from the earlier exported version, it is written to `experiment.new.toml`.
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
from .safe_names import is_unsafe_name
from .transaction import JOURNAL, Move, move_all, recover, remove_empty

EXPERIMENT = "experiment.toml"
NEW_EXPERIMENT = "experiment.new.toml"
PART = ".cardsflow-export.part"
"""Subfolder in which new files are written before they replace the old files."""


def require_folder(folder: str | Path) -> Path:
    """Return the folder to export to.

    Raises:
        InputError: The path is not a folder, is a link, or has a name that a system rejects.
    """
    folder = Path(os.path.abspath(folder))  # noqa: PTH100 - a link must be detected, not resolved
    if not folder.name:
        raise InputError("is a drive; specify a folder on it", file=folder)
    if is_unsafe_name(folder.name):
        problem = "has a name that some operating systems reject; choose another name"
        raise InputError(problem, file=folder)
    if folder.is_symlink():
        raise InputError("is a link; specify its target folder", file=folder)
    if folder.exists() and not folder.is_dir():
        raise InputError("is a file; specify a folder", file=folder)
    return folder


@contextmanager
def folder_replacement(folder: str | Path) -> Iterator[Replacement]:
    """Write new files for a folder to a subfolder; `commit` moves them to the folder.

    Without a successful `commit` the folder is unchanged.

    Raises:
        InputError: The folder cannot be written, or contains files that would be overwritten.
        MachineError: The disk is full.
    """
    folder = require_folder(folder)
    created = [path for path in (folder, *folder.parents) if not path.exists()]  # innermost first
    staging = folder / PART
    try:
        _prepare(folder, staging)
        yield Replacement(folder, staging)
    except OSError as error:
        name = f" ({Path(error.filename).name})" if isinstance(error.filename, str) else ""
        raise file_error(error, f"cannot be written{name}", folder) from error
    except (InputError, MachineError) as error:
        kind = type(error)
        if kind in (InputError, MachineError) and error.file and error.file.is_relative_to(staging):
            raise kind(error.problem, file=folder) from error
        raise
    finally:
        _tidy(staging, created)


def _prepare(folder: Path, staging: Path) -> None:
    if staging.is_symlink() or staging.is_file():
        raise InputError("blocks the export; remove it", file=staging)
    folder.mkdir(parents=True, exist_ok=True)
    recover(folder, staging)
    if staging.exists():
        shutil.rmtree(staging)
    for name in ("new", "old"):
        (staging / name).mkdir(parents=True)


def _tidy(staging: Path, created: list[Path]) -> None:
    """Remove the subfolder, and the created folders if they are empty."""
    if (staging / JOURNAL).exists():
        return  # neither completed nor undone; the next export recovers
    shutil.rmtree(staging, ignore_errors=True)
    with suppress(OSError):
        for path in created:
            path.rmdir()


class Replacement:
    """Replacement of the files of a folder.

    Attributes:
        folder: Target folder.
        new: Folder in which the new files are written.
    """

    def __init__(self, folder: Path, staging: Path) -> None:
        self.folder = folder
        self.new = staging / "new"
        self._staging = staging
        self._findings: list[Finding] = []

    def commit(
        self, contents: Mapping[str, tuple[str, str]] | None = None
    ) -> tuple[tuple[Path, ...], list[Finding]]:
        """Replace the old files with the new files.

        Args:
            contents: Description of the robot, which is stored in the manifest.

        Returns:
            All files of the export, including unchanged ones, and findings on files of the user
            that were kept.

        Raises:
            InputError: The export would overwrite a file that no export wrote.
            OSError: A file could not be moved; all files are unchanged.
        """
        old_marks = read_manifest(self.folder)
        marks = {path: digest((self.new / path).read_bytes()) for path in _files(self.new)}
        of_experiment = self._keep_experiment(old_marks, marks)
        stale = [path for path in old_marks if path not in marks and (self.folder / path).exists()]
        old = [*stale, *self._to_replace(old_marks, marks, stale)]
        moves = [move for path in old for move in self._moves_to_remove(path, old_marks[path])]
        if (self.folder / MANIFEST).exists():
            moves.append((MANIFEST, f"{PART}/old/{MANIFEST}"))
        moves += [(f"{PART}/new/{path}", path) for path in _files(self.new)]
        text = manifest_text(marks | of_experiment, contents)
        (self.new / MANIFEST).write_text(text, encoding="utf-8", newline="\n")
        moves.append((f"{PART}/new/{MANIFEST}", MANIFEST))
        move_all(self.folder, self._staging, moves)
        for path in stale:
            remove_empty(self.folder, path)
        return tuple(self.folder / path for path in marks), self._findings

    def _keep_experiment(self, old: dict[str, str], marks: dict[str, str]) -> dict[str, str]:
        """Remove an experiment that the user has changed from both lists.

        Args:
            old: Fingerprints of the earlier export; modified.
            marks: Fingerprints of the new export; modified.

        Returns:
            Fingerprint of the experiment of the earlier export, for the manifest. The next export
            reports its experiment only if it differs from this one.
        """
        file = self.folder / EXPERIMENT
        if not file.is_file():
            return {}
        present, base, new = digest(file.read_bytes()), old.get(EXPERIMENT), marks.get(EXPERIMENT)
        if present in (base, new):
            return {}
        old.pop(EXPERIMENT, None)
        if new is None:
            return {}
        del marks[EXPERIMENT]
        if new == base:
            (self.new / EXPERIMENT).unlink()
        else:
            (self.new / EXPERIMENT).replace(self.new / NEW_EXPERIMENT)
            marks[NEW_EXPERIMENT] = new
            problem = f"you changed it, so it is kept; the new version is in {NEW_EXPERIMENT}"
            self._warn(EXPERIMENT, "experiment-kept", problem)
        return {} if base is None else {EXPERIMENT: base}

    def _to_replace(
        self, old: dict[str, str], marks: dict[str, str], stale: list[str]
    ) -> list[str]:
        """Return the changed files to replace; discard new files that are unchanged."""
        replaced, unknown = [], []
        for path in (*stale, *marks):
            self._require_free(self.folder / path)
        for path in marks:
            target = self.folder / path
            if not target.exists() or self._is_stale(path, stale):
                continue
            if target.read_bytes() == (self.new / path).read_bytes():
                (self.new / path).unlink()
            elif path in old:
                replaced.append(path)
            else:
                unknown.append(path)
        if unknown:
            problem = (
                f"contains files that no export wrote: {', '.join(unknown[:5])}"
                f"{', ...' if len(unknown) > 5 else ''}; move them, or export into another folder"
            )
            raise InputError(problem, file=self.folder)
        return replaced

    def _is_stale(self, path: str, stale: list[str]) -> bool:
        """Return whether a path is an obsolete file on a case-insensitive file system."""
        alike = [old for old in stale if old.casefold() == path.casefold()]
        return any((self.folder / old).samefile(self.folder / path) for old in alike)

    def _require_free(self, target: Path) -> None:
        """Reject links, files instead of folders, and folders instead of files."""
        below = target.relative_to(self.folder).parents
        for folder in (self.folder / parent for parent in below):
            if folder.is_symlink() and folder != self.folder:
                raise InputError("is a link; remove it, or export elsewhere", file=folder)
            if folder.exists() and not folder.is_dir():
                raise InputError("is a file, but a folder is required; move it", file=folder)
        if target.is_symlink():
            raise InputError("is a link; remove it, or export elsewhere", file=target)
        if target.is_dir():
            raise InputError("is a folder, but a file is required; move it", file=target)

    def _moves_to_remove(self, path: str, mark: str) -> list[Move]:
        """Return the moves that remove a file of the earlier export."""
        old = f"{PART}/old/{path}"
        if digest((self.folder / path).read_bytes()) == mark:
            return [(path, old)]
        backup = f"{path}.bak"
        number = 2
        while os.path.lexists(self.folder / backup):
            backup = f"{path}.bak{number}"
            number += 1
        problem = f"it was changed after the previous export; the changed file is now {backup}"
        self._warn(path, "changed-file-kept", problem)
        return [(path, old), (old, backup)]

    def _warn(self, path: str, code: str, problem: str) -> None:
        self._findings.append(warning(Subject("file", path), code, problem))


def _files(folder: Path) -> list[str]:
    """Return the relative paths of the files below a folder, in order."""
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file())
