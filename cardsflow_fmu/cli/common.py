"""What the commands of the command line share: exit codes, how a command is added, settings."""

from __future__ import annotations

import argparse
import json
import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment

INTERRUPTED, BAD_INPUT, FAILED, GOOD = 130, 2, 1, 0

EXIT_CODES = """exit codes:
  0    it is done
  1    it failed, or has found what it looks for: errors, differences, too weak muscles
  2    the input or the options are wrong; nothing has been done
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); what a run gave so far is there"""


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


def add_json(parser: argparse.ArgumentParser, what: str = "it") -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help=f"print {what} as JSON")


def print_files(files: Iterable[Path], as_json: bool, **others: Any) -> None:
    """Print which files have been written, a line each, or all as JSON.

    Args:
        files: The files.
        as_json: Whether as JSON.
        others: What JSON tells besides.
    """
    paths = [str(file) for file in files]
    if as_json:
        print(json.dumps({"files": paths} | others, indent=1))
    else:
        for path in paths:
            print(path)


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


def add_experiment(parser: argparse.ArgumentParser, others: str = "") -> None:
    """Add an experiment, and settings that change it."""
    parser.add_argument(
        "experiment", type=Path, help=f"an experiment.toml, or the folder that holds one{others}"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a setting, such as controller.period=0.01; may be repeated",
    )


def experiment_of(options: argparse.Namespace) -> Experiment:
    """The experiment that `add_experiment` has asked for."""
    from cardsflow_fmu.experiment.experiment import Experiment

    return Experiment.load(options.experiment, settings_of(options.set))
