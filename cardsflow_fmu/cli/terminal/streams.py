"""Output streams of the commands: without control characters, tolerant of closed pipes."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

_CONTROLS = (*range(0x20), *range(0x7F, 0xA0), 0x2028, 0x2029)
_MARKS = (0x061C, 0x200E, 0x200F)
_DIRECTIONS = (*_MARKS, *range(0x202A, 0x202F), *range(0x2066, 0x206A))  # reorder shown text
_ESCAPED = {
    code: f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
    for code in (*_CONTROLS, *_DIRECTIONS)
    if chr(code) not in "\n\t"
}


def printable(text: str, encoding: str = "utf-8") -> str:
    """Return a text with control characters and unencodable characters as escapes."""
    text = text.translate(_ESCAPED)
    return text.encode(encoding, "backslashreplace").decode(encoding)


class PrintableStream:
    """Stream that escapes control characters.

    Args:
        is_needed: Whether a failed write is an error. A closed pipe is never an error.

    Attributes:
        inner: The wrapped stream, for progress bars, which require control characters.
    """

    def __init__(self, stream: TextIO, *, is_needed: bool) -> None:
        self.inner, self._is_needed = stream, is_needed

    def write(self, text: str) -> int:
        """Write a text with its control characters escaped."""
        return self.write_control(printable(text, self.inner.encoding or "utf-8"))

    def write_control(self, text: str) -> int:
        """Write a text as it is, such as the code of a colour."""
        with self._tolerate_closed():
            self.inner.write(text)
        return len(text)

    def flush(self) -> None:
        """Write the buffered text."""
        with self._tolerate_closed():
            self.inner.flush()

    def __getattr__(self, name: str) -> Any:
        """Return any other attribute of the inner stream."""
        return getattr(self.inner, name)

    @contextlib.contextmanager
    def _tolerate_closed(self) -> Iterator[None]:
        try:
            yield
        except (OSError, ValueError) as error:  # a closed stream raises ValueError
            if self._is_needed and not isinstance(error, BrokenPipeError):
                if isinstance(error, OSError):
                    error.filename = "the output"
                raise
            discard_output(self.inner)


def discard_output(stream: Any) -> None:
    """Redirect a stream to the null device, so that closing it raises no error."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


@contextlib.contextmanager
def printable_streams() -> Iterator[None]:
    """Replace stdout and stderr by `PrintableStream`; closed ones discard their output.

    The context also occupies file descriptors 0 to 2 if they are closed. Otherwise a file could get
    one of them, and libraries would print into it.
    """
    with contextlib.suppress(OSError):
        while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:
            pass
        os.close(descriptor)
    with contextlib.ExitStack() as stack:
        out, err = (
            stack.enter_context(open(os.devnull, "w")) if stream is None else stream  # noqa: PTH123
            for stream in (sys.stdout, sys.stderr)
        )
        stack.enter_context(contextlib.redirect_stdout(PrintableStream(out, is_needed=True)))
        stack.enter_context(contextlib.redirect_stderr(PrintableStream(err, is_needed=False)))
        yield
