"""Compiled C files in pytest's cache, so that programs share them."""

from __future__ import annotations

import fcntl
import hashlib
import os
import shutil
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from cardsflow_fmu.runtime.sources import CONTROL, CORE, FMI

ROOT = Path(__file__).parents[3]
CACHE = ROOT / ".pytest_cache/d/objects"
KEPT = 14 * 86400.0
"""Time after which unused files are removed, in [s]."""


def compile_objects(
    command: Sequence[str], sources: Sequence[str], run: Callable[[list[Any]], str]
) -> list[str]:
    """Return the object files of sources; compile those that are not in the cache.

    Args:
        command: Compiler and flags, without sources and output.
        sources: Paths of C files.
        run: Function that runs a command and raises an error if it fails.
    """
    version = run([command[0], "--version"])
    folder = CACHE / hashlib.sha256(repr((command, version)).encode()).hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    objects = [folder / f"{Path(source).stem}-{_fingerprint(source)}.o" for source in sources]
    with _locked(folder):
        for source, made in zip(sources, objects, strict=True):
            if made.exists():
                os.utime(made)
            else:
                aside = made.with_suffix(f".{os.getpid()}")
                run([*command, "-c", source, "-o", aside])
                aside.replace(made)
        _remove_old(folder)
    return list(map(str, objects))


def _fingerprint(source: str) -> str:
    """Return the hash of a source, all headers, and all sources if it includes some of them."""
    text = Path(source).read_bytes()
    of_others = _contents("*.h") + (_contents("*.c") if b'.c"' in text else b"")
    return hashlib.sha256(source.encode() + text + of_others).hexdigest()[:16]


@cache
def _contents(pattern: str) -> bytes:
    """Return the hash of all files of core, laws and runtime."""
    digest = hashlib.sha256()
    for folder in sorted({name for one in (CORE, CONTROL, FMI) for name in one.folders}):
        for path in sorted((ROOT / folder).rglob(pattern)):
            digest.update(path.read_bytes())
    return digest.digest()


def _remove_old(folder: Path) -> None:
    oldest = time.time() - KEPT
    for path in folder.glob("*.o"):
        if path.stat().st_mtime < oldest:
            path.unlink()
    for other in CACHE.iterdir():
        if other.stat().st_mtime < oldest and other != folder:
            shutil.rmtree(other, ignore_errors=True)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Lock a file, so that only one process compiles it."""
    with (folder / "lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
