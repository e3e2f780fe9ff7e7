"""Commands of the add-in: each defines its dialog in `dialog.py` and its actions in `entry.py`."""

from __future__ import annotations

import importlib
from typing import Any

COMMANDS = ("define_muscles", "check", "export")
"""Folders of the commands, in the order of their buttons."""


def load(name: str) -> Any:
    """Return the command of a folder; it requires Fusion or the fake Fusion API."""
    return importlib.import_module(f".{name}.entry", __package__).COMMAND
