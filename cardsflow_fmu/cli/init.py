"""`cardsflow init`, `schema` and `completion`: what one needs before the first run."""

from __future__ import annotations

import argparse
import json
from functools import partial
from pathlib import Path
from typing import Any

from .common import GOOD, add_command, add_json, print_files

KINDS = ("experiment", "study")
SHELLS = ("bash", "zsh", "fish")


def add_start(
    commands: Any, common: argparse.ArgumentParser, parser: argparse.ArgumentParser
) -> None:
    """Add `init`, `schema` and `completion`.

    Args:
        commands: Where to.
        common: Options that all commands have.
        parser: The whole command line, which is completed.
    """
    _add_init(commands, common)
    _add_schema(commands, common)
    _add_completion(commands, common, parser)


def _add_init(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "init",
        "Write a commented experiment.toml for a robot, ready to run.",
        "cardsflow init examples/planar_2r/robot -o my_arm/experiment.toml",
    )
    parser.add_argument("robot", type=Path, help="a model.sdf, a *_bodies.xml, or their folder")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("experiment.toml"),
        metavar="FILE",
        help="where to, never over a file that is there; experiment.toml",
    )
    parser.add_argument("--cable-set", help="the cable set to use; the file's own when left out")
    add_json(parser, "the file")
    parser.set_defaults(command=_init)


def _add_schema(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "schema",
        "Print the JSON Schema of experiment.toml or study.toml, by which editors complete and "
        "check them.",
        "cardsflow schema > experiment.schema.json",
    )
    parser.add_argument("kind", nargs="?", choices=KINDS, default=KINDS[0], help="of which file")
    parser.set_defaults(command=_schema)


def _add_completion(
    commands: Any, common: argparse.ArgumentParser, whole: argparse.ArgumentParser
) -> None:
    parser = add_command(
        commands,
        common,
        "completion",
        "Print what makes a shell complete commands, options and files.",
        "cardsflow completion bash > ~/.local/share/bash-completion/completions/cardsflow",
    )
    parser.add_argument("shell", choices=SHELLS, help="the shell")
    parser.set_defaults(command=partial(_completion, whole))


def _init(options: argparse.Namespace) -> int:
    from cardsflow_fmu.experiment.template import init

    print_files([init(options.robot, options.output, options.cable_set)], options.json)
    return GOOD


def _schema(options: argparse.Namespace) -> int:
    from .json_schema import schema

    print(json.dumps(schema(options.kind), indent=1, ensure_ascii=False))
    return GOOD


def _completion(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    import shtab

    _complete_files(parser, shtab.FILE)
    print(shtab.complete(parser, options.shell))
    return GOOD


def _complete_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Let every argument that is a path be completed by files."""
    for action in parser._actions:  # argparse has no other way to walk a parser
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                _complete_files(inner, files)
        elif action.type is Path:
            action.complete = files  # type: ignore[attr-defined]
