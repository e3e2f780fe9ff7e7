"""Exit codes, arguments and output that the commands share."""

from __future__ import annotations

import argparse
import os
import sys
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import Finding, InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.config.file import require_sizes
from cardsflow_fmu.experiment.config.key_path import split_setting

from .terminal.messages import print_coloured, print_note

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment

ROBOT_FILE = "a robot file (.sdf, .urdf, .osim, MJCF .xml, *_bodies.xml) or its folder"
DOUBTFUL, FAILED, GOOD = 3, 1, 0

_MAX_REPEATED = 3  # findings of one kind that are printed one by one
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def use_one_thread() -> None:
    """Let NumPy use one thread, unless the user chose a number; call before its import.

    Matrices are small: threads would mostly wait for each other on a busy machine.
    """
    os.environ.update({name: os.environ.get(name, "1") for name in _THREADS})


def add_json(parser: argparse.ArgumentParser, output: str = "the result") -> None:
    """Add `--json`."""
    text = f"print {output} as JSON (default: as text)"
    parser.add_argument("--json", action="store_true", help=text)


def add_output(parser: argparse.ArgumentParser, text: str, **options: Any) -> None:
    """Add `-o`."""
    if options.get("required"):
        text += " (required)"
    elif "default" in options:
        text += f" (default: {options['default']})"
    parser.add_argument("-o", "--output", type=Path, help=text, **options)


def add_overwrite(parser: argparse.ArgumentParser) -> None:
    """Add `--overwrite`."""
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace the output file even if CARDSFlow did not write it or it may have been "
        "edited (default: off)",
    )


def add_settings(
    parser: argparse.ArgumentParser, kind: str = "setting", example: str = "controller.period=0.01"
) -> None:
    """Add `--set`, for settings of some kind, with an example."""
    text = f"change a {kind}, such as {example}; repeatable (default: none)"
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help=text)


def add_robot(parser: argparse.ArgumentParser, others: str = "") -> None:
    """Add a robot and its cable set."""
    text = f"{ROBOT_FILE}{others}"
    parser.add_argument("robot", type=Path, help=text)
    add_cable_set(parser)


def add_cable_set(parser: argparse.ArgumentParser, whose: str = "file") -> None:
    """Add `--cable-set`."""
    text = f"name of the cable set to use (default: the active set of the {whose})"
    parser.add_argument("--cable-set", metavar="NAME", help=text)


def add_words(parser: argparse.ArgumentParser, option: str, metavar: str, text: str) -> None:
    """Add an option with a comma-separated list of words."""
    parser.add_argument(option, type=_words, default=[], metavar=f"{metavar},...", help=text)


def _words(text: str) -> list[str]:
    return [word.strip() for word in text.split(",") if word.strip()]


def add_verbose(
    parser: argparse.ArgumentParser,
    text: str = "print every finding (default: one line for findings that repeat)",
) -> None:
    """Add `--verbose`."""
    parser.add_argument("--verbose", action="store_true", help=text)


def print_findings(
    findings: Iterable[Finding], verbose: bool = False, rest: str = "--verbose"
) -> None:
    """Print findings to stderr; see `finding_lines`. With `--quiet` only errors are printed."""
    for finding, line in finding_lines(findings, verbose, rest):
        if finding.is_error:
            print_coloured(line, sys.stderr)
        else:
            print_note(line, prefix="")


def finding_lines(
    findings: Iterable[Finding], verbose: bool = False, rest: str = "--verbose"
) -> Iterator[tuple[Finding, str]]:
    """Yield findings with their lines; repeated findings of one kind share one line.

    Args:
        findings: The findings in their order.
        verbose: Whether every finding has its own line.
        rest: The option or command that prints all findings, for the shared line.
    """
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        kind = kinds.setdefault((finding.severity, finding.code), [])
        kind.append(finding)
    for kind in kinds.values():
        if verbose or len(kind) <= _MAX_REPEATED:
            yield from ((finding, str(finding)) for finding in kind)
            continue
        names = ", ".join(repr(finding.subject.name) for finding in kind[1 : 1 + _MAX_REPEATED])
        more = ", ..." if len(kind) > 1 + _MAX_REPEATED else ""
        others = f"and {len(kind) - 1} more of this kind: {names}{more}"
        yield kind[0], f"{kind[0]} {others} (list all: {rest})"


def print_files(files: Iterable[Path], as_json: bool, **others: Any) -> None:
    """Print the files that were written, one per line, or all as JSON."""
    paths = [str(file) for file in files]
    if as_json:
        print(json_text({"files": paths} | others, indent=1))
    else:
        for path in paths:
            print(path)


def print_result(text: str) -> None:
    """Print the text of a result; the word WARNING is coloured on a terminal."""
    for line in text.splitlines():
        print_coloured(line)


def parse_settings(words: Sequence[str]) -> dict[str, Any]:
    """Convert `KEY=VALUE` words to settings. A value that is not valid TOML is a string."""
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
            raise InputError("the value cannot be read", key=f"--set {key}") from None
    return settings


def add_experiment(parser: argparse.ArgumentParser, others: str = "") -> None:
    """Add an experiment, and settings that change it."""
    parser.add_argument(
        "experiment", type=Path, help=f"an experiment.toml or the folder that contains it{others}"
    )
    add_settings(parser)


def load_experiment(options: argparse.Namespace) -> Experiment:
    """Load the experiment of the options of `add_experiment`."""
    from cardsflow_fmu.experiment.experiment import Experiment

    return Experiment.load(options.experiment, parse_settings(options.set))
