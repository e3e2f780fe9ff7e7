"""Commands of the add-in: each has its dialog in `dialog.py` and its work in `entry.py`."""

from __future__ import annotations

import importlib
from typing import Any

COMMANDS = ("define_muscles", "check", "export")
"""The folders of the commands, in the order of the buttons."""


def load(name: str) -> Any:
    """Return the command of a folder; it runs in Fusion, or a fake of it, only."""
    return importlib.import_module(f".{name}.entry", __package__).COMMAND
