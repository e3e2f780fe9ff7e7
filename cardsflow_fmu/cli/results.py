"""`cardsflow plot`, `compare`, `report` and `convert`: results of runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from addin_sdfusion.robot import InputError, UnknownNameError
from addin_sdfusion.robot.json_text import json_text

from .common import (
    FAILED,
    GOOD,
    add_json,
    add_output,
    add_overwrite,
    add_words,
    print_files,
)
from .parser import Commands
from .terminal.messages import print_warning
from .terminal.progress import show_progress

_RESULTS = "the folder of a run, or a table (.csv)"
_PANELS = (
    "forces, torques, tracking, errors, estimate, loads, innovation, lengths, moment_arms, "
    "solve_times, slack"
)


def add_plot(commands: Commands) -> None:
    """Add `plot`."""
    parser = commands.add(
        "plot",
        _plot,
        "Plot results over time as a figure.",
        "cardsflow plot results --panels forces,moment_arms -o arms.pdf",
    )
    parser.add_argument("results", type=Path, help=_RESULTS)
    text = "the figure: .png, .svg or .pdf"
    add_output(parser, text, default=Path("plot.png"), metavar="FILE")
    add_overwrite(parser)
    default = "(default: forces, torques, tracking and errors, unless --columns is given)"
    add_words(parser, "--panels", "NAME", f"panels to draw: {_PANELS} {default}")
    text = "columns to draw by name, such as 'q.*,f.cable_1' (default: none)"
    add_words(parser, "--columns", "PATTERN", text)
    add_json(parser, "the file name")


def add_compare(commands: Commands) -> None:
    """Add `compare`."""
    parser = commands.add(
        "compare",
        _compare,
        "Compare two results column by column.",
        "cardsflow compare results reference --atol 1e-9",
        "The exit code is 1 if they differ.",
    )
    parser.add_argument("first", type=Path, help=_RESULTS)
    parser.add_argument("second", type=Path, help=f"the reference: {_RESULTS}")
    text = "absolute tolerance, in the unit of each column (default: 0)"
    parser.add_argument("--atol", type=float, default=0.0, metavar="X", help=text)
    parser.add_argument(
        "--rtol",
        type=float,
        default=0.0,
        metavar="X",
        help="relative tolerance, added to the absolute one: part of the magnitude of the second "
        "result (default: 0)",
    )
    text = "columns to compare by name, such as 'q.*,f.cable_1' (default: all)"
    add_words(parser, "--columns", "PATTERN", text)
    add_json(parser, "the comparison")


def add_report(commands: Commands) -> None:
    """Add `report`."""
    parser = commands.add(
        "report",
        _report,
        "Write a self-contained HTML page of a run.",
        "cardsflow report results -o report.html",
        "It contains the summary, a 3-D replay, figures, the robot and the experiment.",
    )
    parser.add_argument("results", type=Path, help="the folder of a run")
    add_output(parser, "the HTML page", default=Path("report.html"), metavar="FILE")
    add_overwrite(parser)
    add_json(parser, "the file name")


def _plot(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.figures import missing_characters, plot
    from cardsflow_fmu.results.saved_run import open_results

    with open_results(options.results) as result:
        file = plot(
            result, options.output, options.panels, options.columns, overwrite=options.overwrite
        )
        characters = missing_characters(result)
    if characters and file.suffix.lower() != ".svg":
        print_warning(
            f"the font of the figure does not contain {characters!r}; boxes replace them; use .svg"
        )
    print_files([file], options.json)
    return GOOD


def _compare(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.compare import compare, describe_comparison

    comparison = compare(options.first, options.second, options.atol, options.rtol, options.columns)
    print(json_text(comparison, indent=1) if options.json else describe_comparison(comparison))
    return GOOD if comparison["equal"] else FAILED


def _report(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.page import report

    with show_progress("report"):
        page = report(options.results, options.output, overwrite=options.overwrite)
    print_files([page], options.json)
    return GOOD


def convert_recording(options: argparse.Namespace) -> int:
    """Convert results to a ROS 2 recording, or a recording to a motion; see `convert`."""
    file = Path(options.to)
    for option in ("output", "cable_set"):
        if getattr(options, option) is not None:
            key = f"--{option.replace('_', '-')}"
            raise InputError("is only for robots; --to names the file", key=key)
    if file.suffix == ".csv":
        from cardsflow_fmu.experiment.recorded_motion import write_motion

        written = write_motion(options.robot, file, overwrite=options.overwrite)
        print_files([written], options.json)
        return GOOD
    if file.suffix != ".mcap":
        raise UnknownNameError("format", file.name, ["run.mcap", "motion.csv"], key="--to")
    from cardsflow_fmu.ros.recording import convert_run

    with show_progress("convert"):
        recorded = convert_run(options.robot, file, overwrite=options.overwrite)
    if not options.json:
        for note in recorded.notes:
            print_warning(note)
    print_files([recorded.file], options.json, topics=recorded.topics, notes=recorded.notes)
    return GOOD
