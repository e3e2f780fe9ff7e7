"""`cardsflow examples`: list the examples that come with the package, and copy them."""

from __future__ import annotations

import argparse
import re
import shutil
from pathlib import Path

from addin_sdfusion.robot import InputError, UnknownNameError
from addin_sdfusion.robot.files import file_error
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cli.common import GOOD, add_json, print_files
from cardsflow_fmu.cli.parser import Commands
from cardsflow_fmu.cli.terminal.messages import print_note
from cardsflow_fmu.experiment.examples import examples_folder

_OTHER_EXAMPLE = re.compile(r"""["'](?:\.\./)+(\w+)""")
_IGNORED = ("results", "__pycache__", ".*", "*.pyc", "*.fmu")


def add_examples(commands: Commands) -> None:
    """Add `examples` and its actions."""
    text = "List or copy the examples that come with CARDSFlow."
    actions = commands.group("examples", text, "cardsflow examples list")
    parser = actions.add("list", _list, "List the examples.", "cardsflow examples list")
    add_json(parser, "the examples")
    parser = actions.add(
        "copy",
        _copy,
        "Copy an example into a folder.",
        "cardsflow examples copy planar_2r .",
        "Other examples that it uses are copied as well. Existing folders are never replaced.",
    )
    parser.add_argument("name", help="name of the example; see `cardsflow examples list`")
    text = "folder in which the folder of the example is created (default: .)"
    parser.add_argument("folder", metavar="DIR", type=Path, nargs="?", default=Path(), help=text)
    add_json(parser, "the folder names")


def example_titles() -> dict[str, str]:
    """Return the title of each example by its name."""
    titles = {}
    for readme in sorted(examples_folder().glob("*/README.md")):
        with readme.open(encoding="utf-8") as stream:
            titles[readme.parent.name] = stream.readline().lstrip("#").strip()
    return titles


def copy_example(name: str, folder: Path) -> tuple[list[Path], list[Path]]:
    """Copy an example and the examples that it uses.

    Returns:
        The folders that were created, and the folders of used examples that existed before.

    Raises:
        UnknownNameError: The example does not exist.
        InputError: The folder of the example exists, or it cannot be written.
    """
    titles = example_titles()
    if name not in titles:
        raise UnknownNameError("example", name, titles, key="NAME")
    target = folder / name
    if target.exists():
        raise InputError("already exists; choose another folder", file=target)
    created, existing = [], []
    for used in _with_dependencies(name):
        target = folder / used
        if target.exists():
            existing.append(target)
            continue
        try:
            shutil.copytree(
                examples_folder() / used, target, ignore=shutil.ignore_patterns(*_IGNORED)
            )
        except OSError as error:
            raise file_error(error, "cannot be written", target) from None
        created.append(target)
    return created, existing


def _with_dependencies(name: str) -> list[str]:
    """Return an example and all examples that its files refer to."""
    names = [name]
    for used in names:  # the loop appends to this list
        for file in sorted((examples_folder() / used).rglob("*")):
            if file.suffix not in (".toml", ".py") or "results" in file.parts:
                continue
            for other in _OTHER_EXAMPLE.findall(file.read_text(encoding="utf-8")):
                if other not in names and (examples_folder() / other / "README.md").is_file():
                    names.append(other)
    return names


def _list(options: argparse.Namespace) -> int:
    titles = example_titles()
    if options.json:
        print(json_text({"examples": titles}, indent=1))
        return GOOD
    width = max(map(len, titles), default=0)
    for name, title in titles.items():
        print(f"{name:<{width}}  {title}")
    return GOOD


def _copy(options: argparse.Namespace) -> int:
    created, existing = copy_example(options.name, options.folder)
    for folder in existing:
        print_note(f"note: {folder} already exists and is used as it is")
    print_files(created, options.json)
    return GOOD
