"""Access to the clipboard through programs of the operating system.

Fusion's API does not provide the clipboard.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence

from ..robot.errors import InputError

_SHELL = (
    os.environ.get("SYSTEMROOT", r"C:\Windows")
    + r"\System32\WindowsPowerShell\v1.0\powershell.exe",
    "-NoProfile",
    "-NonInteractive",
    "-Command",
)
PROGRAMS: dict[str, tuple[Sequence[str], Sequence[str]]] = {
    "win32": (
        (
            *_SHELL,
            "[Console]::InputEncoding = [Text.Encoding]::UTF8; "
            "Set-Clipboard -Value ([Console]::In.ReadToEnd())",
        ),
        (
            *_SHELL,
            "[Console]::OutputEncoding = [Text.Encoding]::UTF8; "
            "[Console]::Out.Write((Get-Clipboard -Raw))",
        ),
    ),
    "darwin": (("/usr/bin/pbcopy",), ("/usr/bin/pbpaste",)),
}
"""Commands that copy to and paste from the clipboard, for each operating system."""

_SECONDS = 20.0
_NO_WINDOW = 0x08000000  # of Windows


def copy(text: str) -> None:
    """Copy a text to the clipboard."""
    _run(0, text)


def paste() -> str:
    """Return the text in the clipboard; empty if it does not contain text."""
    return _run(1, "")


def _run(which: int, text: str) -> str:
    system: str = sys.platform
    if system not in PROGRAMS:
        raise InputError("The clipboard is not available on this system; use a file.")
    try:
        output = subprocess.check_output(
            PROGRAMS[system][which],
            input=text.encode(),
            stderr=subprocess.DEVNULL,
            timeout=_SECONDS,
            env={**os.environ, "LC_CTYPE": "UTF-8"},
            creationflags=_NO_WINDOW if system == "win32" else 0,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise InputError(f"The clipboard cannot be used ({error}); use a file.") from None
    return output.decode(errors="replace").removeprefix("\ufeff")
