"""Output streams of the commands: no control characters, and closed pipes without errors."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

_CONTROLS = (*range(0x20), *range(0x7F, 0xA0), 0x2028, 0x2029)
_MARKS = (0x061C, 0x200E, 0x200F)
_DIRECTIONS = (*_MARKS, *range(0x202A, 0x202F), *range(0x2066, 0x206A))  # reorder what is read
_ESCAPED = {
    code: f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
    for code in (*_CONTROLS, *_DIRECTIONS)
    if chr(code) not in "\n\t"
}


def printable(text: str, encoding: str = "utf-8") -> str:
    """A text with what steers a terminal, and what an encoding lacks, written as escapes."""
    text = text.translate(_ESCAPED)
    return text.encode(encoding, "backslashreplace").decode(encoding)


class PrintableStream:
    """A stream that prints printable text.

    Args:
        stream: Where to.
        is_needed: Whether it is an error where nothing can be written; a reader that has stopped
            reading, as `head` does, never is one.

    Attributes:
        inner: The stream itself, for progress bars, which steer the terminal.
    """

    def __init__(self, stream: TextIO, *, is_needed: bool) -> None:
        self.inner, self._is_needed = stream, is_needed

    def write(self, text: str) -> int:
        """Write a text."""
        with self._excused():
            self.inner.write(printable(text, self.inner.encoding or "utf-8"))
        return len(text)

    def flush(self) -> None:
        """Write what is buffered."""
        with self._excused():
            self.inner.flush()

    def __getattr__(self, name: str) -> Any:
        """Everything else is as of the stream."""
        return getattr(self.inner, name)

    @contextlib.contextmanager
    def _excused(self) -> Iterator[None]:
        try:
            yield
        except (OSError, ValueError) as error:  # a closed one gives ValueError
            if self._is_needed and not isinstance(error, BrokenPipeError):
                if isinstance(error, OSError):
                    error.filename = "the output"
                raise
            let_go(self.inner)


def let_go(stream: Any) -> None:
    """Send what a stream still has, and all that comes, nowhere: so that its end is no error."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextlib.contextmanager
def printable_streams() -> Iterator[None]:
    """Standard output and error that print printable text; a closed one prints nowhere.

    The numbers of closed ones are taken, so that no file gets one of them, into which libraries
    would print.
    """
    with contextlib.suppress(OSError):
        while (taken := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(taken)
    with contextlib.ExitStack() as stack:
        out, err = (
            stack.enter_context(open(os.devnull, "w")) if stream is None else stream  # noqa: PTH123
            for stream in (sys.stdout, sys.stderr)
        )
        stack.enter_context(contextlib.redirect_stdout(PrintableStream(out, is_needed=True)))
        stack.enter_context(contextlib.redirect_stderr(PrintableStream(err, is_needed=False)))
        yield
