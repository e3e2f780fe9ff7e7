"""Exit codes, arguments and output that the commands share."""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import Finding, InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.config.file import require_sizes
from cardsflow_fmu.experiment.config.key_path import split_setting

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment

ROBOT_FILE = "a robot's file (.sdf, .urdf, .osim, MJCF .xml, *_bodies.xml) or its folder"
INTERRUPTED, DOUBTFUL, BAD_INPUT, FAILED, GOOD = 130, 3, 2, 1, 0

_REPEATED = 3  # findings of one kind that have a line each

EXIT_CODES = """exit codes:
  0    it is done
  1    it failed, or has found what it looks for: errors, differences, too weak muscles
  2    the input or the options are wrong; nothing has been done
  3    it is done, with warnings, and `--strict` was asked for
  130  interrupted (Ctrl-C, SIGTERM, SIGHUP); what a run gave so far is there"""


class Commands:
    """The commands below a parser."""

    def __init__(self, parser: argparse.ArgumentParser, metavar: str) -> None:
        self._parsers = parser.add_subparsers(metavar=metavar, required=True)
        self._common = argparse.ArgumentParser(add_help=False)
        self._common.add_argument("--debug", action="store_true", help="show the trace of an error")

    def add(
        self, name: str, run: Callable[[argparse.Namespace], int], text: str, example: str
    ) -> argparse.ArgumentParser:
        """Add a command; returns its parser."""
        parser = self._add(name, text, example, parents=[self._common])
        parser.set_defaults(command=run)
        return parser

    def group(self, name: str, text: str, example: str) -> Commands:
        """Add a command with actions of its own; the arguments are as above."""
        return Commands(self._add(name, text, example), "ACTION")

    def _add(self, name: str, text: str, example: str, **options: Any) -> argparse.ArgumentParser:
        parser: argparse.ArgumentParser = self._parsers.add_parser(
            name,
            help=text,
            description=text,
            epilog=f"example:\n  {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
            **options,
        )
        return parser


def add_json(parser: argparse.ArgumentParser, what: str = "it") -> None:
    """Add `--json`."""
    parser.add_argument("--json", action="store_true", help=f"print {what} as JSON")


def add_output(parser: argparse.ArgumentParser, what: str, **options: Any) -> None:
    """Add `-o`; `options` are those of `add_argument`."""
    parser.add_argument("-o", "--output", type=Path, help=what, **options)


def add_settings(
    parser: argparse.ArgumentParser, what: str = "setting", example: str = "controller.period=0.01"
) -> None:
    """Add `--set`, for settings of some kind, with an example."""
    text = f"change a {what}, such as {example}; may be repeated"
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=text)


def add_robot(parser: argparse.ArgumentParser, others: str = "") -> None:
    """Add a robot and its cable set."""
    what = f"{ROBOT_FILE}{others}"
    parser.add_argument("robot", type=Path, help=what)
    add_cable_set(parser)


def add_cable_set(parser: argparse.ArgumentParser) -> None:
    """Add `--cable-set`."""
    parser.add_argument("--cable-set", help="the cable set to use; the file's own when left out")


def refuse_flags(parser: argparse.ArgumentParser, flags: Sequence[str], instead: str) -> None:
    """Refuse flags that no longer exist, and say what to do instead."""

    class Refused(argparse.Action):
        def __call__(self, parser: Any, namespace: Any, values: Any, option: Any = None) -> None:
            parser.exit(BAD_INPUT, f"cardsflow: {option} is no longer an option: {instead}\n")

    for flag in flags:
        parser.add_argument(flag, action=Refused, nargs=0, help=argparse.SUPPRESS)


def add_words(parser: argparse.ArgumentParser, option: str, metavar: str, text: str) -> None:
    """Add an option with words, commas between them."""
    parser.add_argument(option, type=_words, default=[], metavar=f"{metavar},...", help=text)


def _words(text: str) -> list[str]:
    return [word for word in text.split(",") if word]


def add_verbose(
    parser: argparse.ArgumentParser,
    what: str = "print every finding, not one line for those that repeat",
) -> None:
    """Add `--verbose`."""
    parser.add_argument("--verbose", action="store_true", help=what)


def print_findings(
    findings: Iterable[Finding], verbose: bool = False, rest: str = "--verbose"
) -> None:
    """Print findings to stderr; see `finding_lines`."""
    for line in finding_lines(findings, verbose, rest):
        print(line, file=sys.stderr)


def finding_lines(
    findings: Iterable[Finding], verbose: bool = False, rest: str = "--verbose"
) -> Iterator[str]:
    """Findings as lines: one each, but where one kind repeats, the first and the others' names.

    Args:
        findings: In their order.
        verbose: Whether all have a line.
        rest: What prints all.
    """
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kind = kinds.setdefault((finding.severity, finding.code), [])
        kind.append(finding)
    for kind in kinds.values():
        if verbose or len(kind) <= _REPEATED:
            yield from map(str, kind)
            continue
        names = ", ".join(repr(finding.subject.name) for finding in kind[1 : 1 + _REPEATED])
        more = ", ..." if len(kind) > 1 + _REPEATED else ""
        yield f"{kind[0]} and {len(kind) - 1} more such: {names}{more} ({rest}: all)"


def print_files(files: Iterable[Path], as_json: bool, **others: Any) -> None:
    """Print the files that were written, a line each, or all as JSON."""
    paths = [str(file) for file in files]
    if as_json:
        print(json_text({"files": paths} | others, indent=1))
    else:
        for path in paths:
            print(path)


def print_result(text: str) -> None:
    """Print what a run gave; lines that begin with WARNING are coloured on a terminal."""
    coloured = sys.stdout.isatty() and not os.environ.get("NO_COLOR")
    for line in text.splitlines():
        print(f"\033[1;31m{line}\033[0m" if coloured and line.startswith("WARNING") else line)


def settings_of(words: Sequence[str]) -> dict[str, Any]:
    """`KEY=VALUE` words as settings; a value is TOML, or else a text."""
    settings: dict[str, Any] = {}
    for word in words:
        parts = split_setting(word)
        if parts is None:
            raise InputError(f"must be KEY=VALUE, not {word!r}", key="--set")
        key, value = parts
        try:
            settings[key] = tomllib.loads(f"value = {value}")["value"]
            require_sizes(settings[key], None, f"--set {key}")
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
    add_settings(parser)


def experiment_of(options: argparse.Namespace) -> Experiment:
    """The experiment of the options of `add_experiment`."""
    from cardsflow_fmu.experiment.experiment import Experiment

    return Experiment.load(options.experiment, settings_of(options.set))
