"""`cardsflow study`: many runs of one experiment."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot.json_text import json_text

from .common import FAILED, GOOD, add_json, add_output
from .parser import Commands
from .terminal.messages import print_warning
from .terminal.progress import show_progress

if TYPE_CHECKING:
    from cardsflow_fmu.studies.execution.executors import RunExecutor
    from cardsflow_fmu.studies.run import StudyResult


_MAX_ERRORS = 5


def add_study(commands: Commands) -> None:
    """Add `study`."""
    parser = commands.add(
        "study",
        _study,
        "Run many variants of an experiment, or optimise its parameters.",
        "cardsflow study examples/design_study/attachments.toml -j 2",
        "It writes a table, a report, and a file for each run, so that it can be resumed.",
    )
    parser.add_argument("study", type=Path, help="a study.toml or its folder")
    parser.add_argument(
        "-j",
        "--jobs",
        type=int,
        metavar="N",
        help="number of parallel runs (default: one per core)",
    )
    what = "folder for runs, table and report (default: next to the study)"
    add_output(parser, what, metavar="FOLDER")
    parser.add_argument(
        "--resume", action="store_true", help="continue a study; keep finished runs (default: off)"
    )
    parser.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="Dask scheduler to use, such as tls://host:8786, or `local`; needs the extra `sweep` "
        "(default: processes on this machine)",
    )
    parser.add_argument(
        "--only",
        metavar="HASH",
        help="repeat only the run whose hash starts with HASH; write nothing (default: all runs)",
    )
    add_json(parser, "the summary")


def _study(options: argparse.Namespace) -> int:
    from cardsflow_fmu.studies.analysis.summary import summary_text
    from cardsflow_fmu.studies.definition.study import Study
    from cardsflow_fmu.studies.run import run_study

    study = Study.load(options.study)
    if options.only is not None:
        return _only(options)
    with _executor(options) as executor, show_progress("study", "runs") as update:
        result = run_study(
            study,
            jobs=options.jobs,
            executor=executor,
            resume=options.resume,
            output=options.output,
            progress=update,
        )
    if options.json:
        print(summary_text(result.summary), end="")
    else:
        for warning in result.summary["warnings"]:
            print_warning(warning)
        _print(result)
    has_found = study.optimise is None or result.summary["best"] is not None
    return GOOD if result.summary["complete"] and has_found else FAILED


def _only(options: argparse.Namespace) -> int:
    from cardsflow_fmu.studies.definition.study import Study
    from cardsflow_fmu.studies.run import repeat_run

    command, outcome = repeat_run(Study.load(options.study), options.only, options.output)
    print(command, file=sys.stderr)
    row = {"status": "complete" if outcome.complete else "failed", "error": outcome.error}
    print(json_text(row | {"metrics": outcome.metrics}, indent=1))
    return GOOD if outcome.complete else FAILED


@contextlib.contextmanager
def _executor(options: argparse.Namespace) -> Iterator[RunExecutor | None]:
    """Provide the executor of `--dask`, or None without it."""
    if options.dask is None:
        yield None
        return
    from cardsflow_fmu.studies.execution.dask_executor import dask_executor, dask_warning

    warning = dask_warning(options.dask)
    if warning is not None:
        print_warning(warning)
    jobs = os.cpu_count() or 1 if options.jobs is None else options.jobs
    with dask_executor(options.dask, jobs) as executor:
        yield executor


def _print(result: StudyResult) -> None:
    summary = result.summary
    print(f"{summary['study']}: {summary['runs']} runs, {summary['failed']} failed")
    if others := summary.get("other_runs"):
        print(f"  {others} other runs in the folder belong to another study and are not used")
    for error, count in list(summary["failures"].items())[:_MAX_ERRORS]:
        print(f"  {count} failed: {error}")
    for name, numbers in summary["metrics"].items():
        print(
            f"  {name:<24} median {numbers['median']:.4g}, 5 to 95 % {numbers['p05']:.4g} to "
            f"{numbers['p95']:.4g}, {numbers['min']:.4g} to {numbers['max']:.4g}"
        )
    if "best" in summary:
        best = summary["best"]
        print("best: no run meets the constraints" if best is None else _best_line(best))
    for name, path in sorted(result.files.items()):
        print(f"{name:<18} {path}")


def _best_line(best: dict[str, Any]) -> str:
    return f"best: {best['objective']:.6g} in run {best['run']} ({best['hash']}); robot: best/"
