"""`cardsflow init`, `schema` and `completion`: preparations for a first run."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.cli.common import (
    FAILED,
    GOOD,
    add_json,
    add_output,
    add_overwrite,
    add_robot,
    print_files,
    print_findings,
)
from cardsflow_fmu.cli.parser import Commands
from cardsflow_fmu.cli.terminal.messages import print_error, print_warning
from cardsflow_fmu.cli.terminal.progress import show_progress

if TYPE_CHECKING:
    from cardsflow_fmu.simulation.draft_search import TestRun

KINDS = ("experiment", "study", "snapshot")
SHELLS = ("bash", "zsh", "fish")
DIALECT = "https://json-schema.org/draft/2020-12/schema"


def add_init(commands: Commands) -> None:
    """Add `init`."""
    parser = commands.add(
        "init",
        _init,
        "Write a commented experiment.toml for a robot, ready to run.",
        "cardsflow init examples/planar_2r/robot -o my_arm/experiment.toml",
    )
    add_robot(parser)
    text = "the file to write, or a folder for experiment.toml"
    add_output(parser, text, default=Path("experiment.toml"), metavar="FILE")
    add_overwrite(parser)
    add_json(parser, "the file name")


def add_schema(commands: Commands) -> None:
    """Add `schema`."""
    parser = commands.add(
        "schema",
        _schema,
        "Print the JSON Schema of experiment.toml, study.toml or a CAD snapshot.",
        "cardsflow schema > experiment.schema.json",
        "Editors use the schema to complete and check such files.",
    )
    text = f"the kind of file (default: {KINDS[0]})"
    parser.add_argument("kind", nargs="?", choices=KINDS, default=KINDS[0], help=text)


def add_completion(commands: Commands) -> None:
    """Add `completion`."""
    parser = commands.add(
        "completion",
        _completion,
        "Print a shell script that completes commands, options and files.",
        "cardsflow completion bash > ~/.local/share/bash-completion/completions/cardsflow",
    )
    parser.add_argument("shell", choices=SHELLS, help="the shell")


def _init(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.starter import init

    with show_progress("init"):
        starter = init(
            options.robot, options.output, options.cable_set, overwrite=options.overwrite
        )
    code = report_failed_test_run(starter.test_run)
    if not options.json:
        print_findings(starter.findings, rest="cardsflow check")
        for note in starter.notes:
            print_warning(note)
    findings = [finding.as_dict() for finding in starter.findings]
    print_files([starter.file], options.json, notes=starter.notes, findings=findings)
    if not options.json:
        print_test_run(starter.test_run)
    return code


def report_failed_test_run(run: TestRun | None) -> int:
    """Report a failed test run, before all other lines; return the exit code."""
    if run is None or run.is_good:
        return GOOD
    print_error("FAILED: the test run does not follow its reference", prefix="")
    return FAILED


def print_test_run(run: TestRun | None) -> None:
    """Print the result of a test run that passed; the notes describe all others."""
    if run is not None and run.is_good:
        forces = f", muscle forces up to {run.peak:.4g} N" if math.isfinite(run.peak) else ""
        print(f"test run passed: largest tracking error {run.error:.2g} {run.unit}{forces}")


def _schema(options: argparse.Namespace) -> int:
    print(json_text(schema(options.kind), indent=1, ensure_ascii=False))
    return GOOD


def schema(kind: str = "experiment") -> dict[str, Any]:
    """Return the JSON Schema of a file of settings, from the models of its tables.

    The schema does not depend on a robot; the reader checks the names of its parts.

    Args:
        kind: `experiment`, `study` or `snapshot`. A snapshot is a JSON file.
    """
    if kind == "snapshot":
        from addin_sdfusion.snapshot_file import file_schema

        return {"$schema": DIALECT, "title": "design snapshot", **file_schema()}
    from cardsflow_fmu.experiment.config.schema import json_schema
    from cardsflow_fmu.experiment.config.table import Table
    from cardsflow_fmu.experiment.settings.file import ExperimentTables

    tables: type[Table] = ExperimentTables
    if kind == "study":
        from cardsflow_fmu.studies.definition.tables import StudyTables

        tables = StudyTables
    return {"$schema": DIALECT, "title": f"{kind}.toml", **json_schema(tables)}


def _completion(options: argparse.Namespace) -> int:
    import shtab

    _complete_files(options.parser, shtab.FILE)
    print(shtab.complete(options.parser, options.shell))
    return GOOD


def _complete_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Set the completion of every argument that is a path."""
    for action in parser._actions:  # argparse has no public way to walk a parser
        if isinstance(action, argparse._SubParsersAction):
            for inner in action.choices.values():
                _complete_files(inner, files)
        elif action.type is Path:
            action.complete = files  # type: ignore[attr-defined]
