"""`cardsflow faults`: which failures of muscles and motors a robot survives."""

from __future__ import annotations

import argparse

from addin_sdfusion.robot.json_text import json_text

from .common import (
    FAILED,
    GOOD,
    add_experiment,
    add_json,
    add_output,
    add_overwrite,
    load_experiment,
)
from .parser import Commands
from .terminal.progress import show_progress


def add_faults(commands: Commands) -> None:
    """Add `faults`."""
    parser = commands.add(
        "faults",
        _faults,
        "Compute which failures of muscles and motors the motion of an experiment survives.",
        "cardsflow faults examples/roboy_left_arm --double -o faults.svg",
        "A broken muscle has no force. The exit code is 1 if the intact robot is too weak.",
    )
    add_experiment(parser)
    parser.add_argument(
        "--double",
        action="store_true",
        help="also compute failures of two muscles or motors (default: off)",
    )
    add_output(parser, "figure of the required strength, .png, .svg or .pdf (default: none)")
    add_overwrite(parser)
    add_json(parser)


def _faults(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.analysis.failures import describe_failures, failures
    from cardsflow_fmu.results.analysis.look_ahead import worst_reactions
    from cardsflow_fmu.results.report.failures import failure_figure
    from cardsflow_fmu.results.report.figures import figure_file, write_figure

    experiment = load_experiment(options)
    target = options.output and figure_file(options.output, overwrite=options.overwrite)
    with show_progress("faults") as progress:
        results = failures(experiment, 2 if options.double else 1, progress)
        reactions = worst_reactions(experiment) if experiment.robot.muscles else {}
    if target:
        write_figure(target, failure_figure(results))
    if options.json:
        rows = [
            {**failure.as_dict(), "reaction": reactions.get(" and ".join(failure.actuators))}
            for failure in results
        ]
        print(json_text({"failures": rows}, indent=1))
    else:
        print(describe_failures(results, reactions))
        if target:
            print(f"\nfigure  {target}")
    return GOOD if results[0].is_survived else FAILED
