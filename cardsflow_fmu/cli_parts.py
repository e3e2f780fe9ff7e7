"""What the commands of the command line share: exit codes, how a command is added, settings."""

from __future__ import annotations

import argparse
import tomllib
from collections.abc import Sequence
from typing import Any

from addin_sdfusion.robot import InputError

BAD_INPUT, FAILED, GOOD = 2, 1, 0


def add_command(
    commands: Any, common: argparse.ArgumentParser, name: str, text: str, example: str
) -> argparse.ArgumentParser:
    """Add a command with its help and an example; returns its parser."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        parents=[common],
        help=text,
        description=text,
        epilog=f"example:\n  {example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    return parser


def settings_of(words: Sequence[str]) -> dict[str, Any]:
    """`KEY=VALUE` words as settings; a value is TOML, or else a text."""
    settings: dict[str, Any] = {}
    for word in words:
        key, equals, value = word.partition("=")
        if not equals or not key:
            raise InputError(f"must be KEY=VALUE, not {word!r}", key="--set")
        try:
            settings[key] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            settings[key] = value
        except (ValueError, RecursionError):
            raise InputError("its value cannot be read", key=f"--set {key}") from None
    return settings
