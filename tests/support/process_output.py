"""Files of a folder, and output of programs."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

MAX_WAIT = 120.0
"""Maximum waiting time for a program, in [s]."""


def files_of(folder: Path) -> dict[str, bytes]:
    """Return the content of every file below a folder, by its path."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def wait_until(holds: Callable[[], object], seconds: float = 300.0) -> bool:
    """Wait until a condition holds; return whether it does within the given time."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


def read_lines_until(process: subprocess.Popen[str], what: str) -> list[str]:
    """Return the output lines of a program up to the first line that contains a text."""
    assert process.stdout is not None
    lines: list[str] = []
    end = time.monotonic() + MAX_WAIT
    while not lines or what not in lines[-1]:
        lines.append(process.stdout.readline())
        assert lines[-1], lines
        assert time.monotonic() < end
    return lines
