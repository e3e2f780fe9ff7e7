"""Messages of the commands: errors, warnings, notes; colours on a terminal; `--quiet`."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

_RESET, _RED, _YELLOW, _CYAN = "\033[0m", "\033[1;31m", "\033[1;33m", "\033[1;36m"
_COLOURS = {"error": _RED, "FAILED": _RED, "warning": _YELLOW, "WARNING": _YELLOW, "note": _CYAN}
_SEVERITY = re.compile(r"(?<![^\s])(error:|FAILED:|warning:|note:|WARNING)")
_QUIET: ContextVar[bool] = ContextVar("quiet", default=False)


@contextmanager
def quiet_messages(is_quiet: bool) -> Iterator[None]:
    """Print no warnings, notes and progress inside the context if `is_quiet`."""
    token = _QUIET.set(is_quiet)
    try:
        yield
    finally:
        _QUIET.reset(token)


def is_quiet() -> bool:
    """Return whether warnings, notes and progress are suppressed."""
    return _QUIET.get()


def print_error(text: str, prefix: str = "cardsflow: ") -> None:
    """Print an error to stderr; `--quiet` does not suppress it."""
    _write(sys.stderr, [(prefix, _RED), (f"{text}\n", "")])


def print_warning(text: str) -> None:
    """Print a warning to stderr, except with `--quiet`."""
    print_note(f"warning: {text}")


def print_note(text: str, prefix: str = "cardsflow: ") -> None:
    """Print a note to stderr, except with `--quiet`."""
    if not is_quiet():
        print_coloured(f"{prefix}{text}", sys.stderr)


def print_coloured(line: str, stream: Any = None) -> None:
    """Print a line; its severity, such as `warning:`, is coloured on a terminal."""
    match = _SEVERITY.search(line)
    pieces = [(line, "")]
    if match:
        colour = _COLOURS[match[0].rstrip(":")]
        pieces = [(line[: match.start()], ""), (match[0], colour), (line[match.end() :], "")]
    _write(stream or sys.stdout, [*pieces, ("\n", "")])


def _write(stream: Any, pieces: list[tuple[str, str]]) -> None:
    """Write texts, each in its colour where the stream is a terminal."""
    is_coloured = (
        stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"
    )
    control = getattr(stream, "write_control", stream.write)
    for text, colour in pieces:
        if is_coloured and colour:
            control(colour)
            stream.write(text)
            control(_RESET)
        else:
            stream.write(text)
