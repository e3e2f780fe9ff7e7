"""`cardsflow plot`, `compare`, `report` and `convert`: results of runs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from addin_sdfusion.robot import InputError, UnknownNameError
from addin_sdfusion.robot.json_text import json_text

from .common import FAILED, GOOD, Commands, add_json, add_output, add_words, print_files

_RESULTS = "the folder of a run, or a table: .csv, .parquet"


def add_plot(commands: Commands) -> None:
    """Add `plot`."""
    parser = commands.add(
        "plot",
        _plot,
        "Draw results over time: forces, torques, tracking and errors, or what you name.",
        "cardsflow plot results --what forces,moment_arms -o arms.pdf",
    )
    parser.add_argument("results", type=Path, help=_RESULTS)
    add_output(parser, "a .png, .svg or .pdf; plot.png", default=Path("plot.png"), metavar="FILE")
    panels = "forces, torques, tracking, errors, estimate, loads, innovation, lengths, "
    panels += "moment_arms, solve_times, slack"
    add_words(parser, "--what", "NAME", panels)
    add_words(parser, "--columns", "PATTERN", "columns by name, such as 'q.*,f.cable_1'")
    add_json(parser, "the file")


def add_compare(commands: Commands) -> None:
    """Add `compare`."""
    parser = commands.add(
        "compare",
        _compare,
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
    add_words(parser, "--columns", "PATTERN", "compare these alone, such as 'q.*,f.cable_1'")
    add_json(parser)


def add_report(commands: Commands) -> None:
    """Add `report`."""
    parser = commands.add(
        "report",
        _report,
        "Write one page that opens from disk: summary, replay, figures, robot, experiment.",
        "cardsflow report results -o report.html",
    )
    parser.add_argument("results", type=Path, help="the folder of a run")
    add_output(parser, "the page; report.html", default=Path("report.html"), metavar="FILE")
    add_json(parser, "the file")


def _plot(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.figures import missing_signs, plot
    from cardsflow_fmu.results.saved_run import read_any

    with read_any(options.results) as result:
        file = plot(result, options.output, options.what, options.columns)
        signs = missing_signs(result)
    if signs and file.suffix.lower() != ".svg":
        what = f"the font of figures has no {signs!r}: boxes stand there; an .svg has them as text"
        print(f"cardsflow: warning: {what}", file=sys.stderr)
    print_files([file], options.json)
    return GOOD


def _compare(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.compare import compare, describe_comparison

    comparison = compare(options.first, options.second, options.tol, options.rtol, options.columns)
    print(json_text(comparison, indent=1) if options.json else describe_comparison(comparison))
    return GOOD if comparison["equal"] else FAILED


def _report(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.page import report

    print_files([report(options.results, options.output)], options.json)
    return GOOD


def convert_recording(options: argparse.Namespace) -> int:
    """Write results as a recording of ROS 2, or its joint states as a motion; see `convert`."""
    file = Path(options.to)
    for option in ("output", "cable_set"):
        if getattr(options, option) is not None:
            key = f"--{option.replace('_', '-')}"
            raise InputError("is for robots; --to names the file", key=key)
    if file.suffix == ".csv":
        from cardsflow_fmu.experiment.recorded_motion import write_motion

        print_files([write_motion(options.robot, file)], options.json)
        return GOOD
    if file.suffix != ".mcap":
        raise UnknownNameError("format", file.name, ["run.mcap", "motion.csv"], key="--to")
    from cardsflow_fmu.ros.recording import convert_run

    recorded = convert_run(options.robot, file)
    if not options.json:
        for note in recorded.notes:
            print(f"warning: {note}", file=sys.stderr)
    print_files([recorded.file], options.json, topics=recorded.topics, notes=recorded.notes)
    return GOOD
