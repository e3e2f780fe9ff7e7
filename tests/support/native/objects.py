"""Compiled C files, kept in pytest's cache: each is compiled once, whatever programs it is in."""

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
"""How long what no program took is kept, in [s]."""


def compile_objects(
    command: Sequence[str], sources: Sequence[str], run: Callable[[list[Any]], str]
) -> list[str]:
    """The object files that a compiler's command makes of sources, compiled where not at hand.

    Args:
        command: Compiler and flags, without sources and output.
        sources: Paths of C files.
        run: Runs a command; fails if it does.
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
    """Of a source with all headers, and with all other sources where it includes some."""
    text = Path(source).read_bytes()
    of_others = _contents("*.h") + (_contents("*.c") if b'.c"' in text else b"")
    return hashlib.sha256(source.encode() + text + of_others).hexdigest()[:16]


@cache
def _contents(pattern: str) -> bytes:
    """Hash of all files of core, laws and runtime."""
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
    """No other process compiles the same meanwhile."""
    with (folder / "lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield
