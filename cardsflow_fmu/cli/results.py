"""`cardsflow plot`, `compare` and `report`: what is done with results."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from .common import FAILED, GOOD, add_command, add_json, print_files

_RESULTS = "the folder of a run, or a table: .csv, .parquet"


def add_results(commands: Any, common: argparse.ArgumentParser) -> None:
    """Add `plot`, `compare` and `report`."""
    _add_plot(commands, common)
    _add_compare(commands, common)
    _add_report(commands, common)


def _add_plot(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "plot",
        "Draw results over time: forces, tracking and errors, or what you name.",
        "cardsflow plot results --what forces,moment_arms -o arms.pdf",
    )
    parser.add_argument("results", type=Path, help=_RESULTS)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("plot.png"),
        metavar="FILE",
        help="a .png, .svg or .pdf; plot.png",
    )
    parser.add_argument(
        "--what",
        type=_words,
        default=[],
        metavar="NAME,...",
        help="forces, tracking, errors, lengths, moment_arms, solve_times, slack",
    )
    parser.add_argument(
        "--columns",
        type=_words,
        default=[],
        metavar="PATTERN,...",
        help="columns by name, such as 'q.*,f.cable_1'",
    )
    add_json(parser, "the file")
    parser.set_defaults(command=_plot)


def _add_compare(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "compare",
        "Compare two results column by column; the exit code is 1 if they differ.",
        "cardsflow compare results reference --tol 1e-9",
    )
    parser.add_argument("first", type=Path, help=_RESULTS)
    parser.add_argument("second", type=Path, help="the other")
    parser.add_argument(
        "--tol", type=float, default=0.0, help="difference allowed, in the column's unit; 0"
    )
    parser.add_argument(
        "--rtol",
        type=float,
        default=0.0,
        help="part of the second's magnitude that is allowed besides; 0",
    )
    parser.add_argument(
        "--columns",
        type=_words,
        default=[],
        metavar="PATTERN,...",
        help="compare these alone, such as 'q.*,f.cable_1'",
    )
    add_json(parser)
    parser.set_defaults(command=_compare)


def _add_report(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "report",
        "Write one page that opens from disk: summary, replay, figures, robot, experiment.",
        "cardsflow report results -o report.html",
    )
    parser.add_argument("results", type=Path, help="the folder of a run")
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        default=Path("report.html"),
        metavar="FILE",
        help="where to; report.html",
    )
    add_json(parser, "the file")
    parser.set_defaults(command=_report)


def _words(text: str) -> list[str]:
    """Words with commas between them."""
    return [word for word in text.split(",") if word]


def _plot(options: argparse.Namespace) -> int:
    from cardsflow_fmu.report.figures import plot
    from cardsflow_fmu.results.saved_run import read_any

    with read_any(options.results) as result:
        file = plot(result, options.output, options.what, options.columns)
    print_files([file], options.json)
    return GOOD


def _compare(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.compare import compare, describe_comparison

    comparison = compare(options.first, options.second, options.tol, options.rtol, options.columns)
    print(json.dumps(comparison, indent=1) if options.json else describe_comparison(comparison))
    return GOOD if comparison["equal"] else FAILED


def _report(options: argparse.Namespace) -> int:
    from cardsflow_fmu.report.page import report

    print_files([report(options.results, options.output)], options.json)
    return GOOD
