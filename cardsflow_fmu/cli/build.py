"""`cardsflow build`: the FMUs of an experiment."""

from __future__ import annotations

import argparse
import sys

from .common import GOOD, Commands, add_experiment, add_json, add_output, experiment_of, print_files


def add_build(commands: Commands) -> None:
    """Add `build`."""
    parser = commands.add(
        "build",
        _build,
        "Build plant, controller, reference and hardware.fmu of an experiment, sensors and "
        "estimator.fmu where it has an estimator, and system.ssp.",
        "cardsflow build examples/planar_2r -o fmus",
    )
    add_experiment(parser)
    add_output(parser, "folder for the FMUs", required=True)
    parser.add_argument(
        "--fmi",
        choices=("2.0", "3.0"),
        default="2.0",
        help="version of FMI; the .ssp holds FMUs of FMI 2.0 all the same",
    )
    parser.add_argument(
        "--scalars",
        action="store_true",
        help="variables one by one in FMI 3.0 too, for tools without arrays",
    )
    parser.add_argument(
        "--platforms",
        type=lambda text: text.split(","),
        metavar="NAME,...",
        help="what the FMUs run on: linux64, win64, darwin64, aarch64-linux, ...; when not given "
        "this platform, native ones all that came with the package; others need the extra `cross`",
    )
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument(
        "--native",
        action="store_true",
        default=None,
        help="plant, controller and reference in C, or nothing: without it those that can; "
        "they need no Python where they run",
    )
    kind.add_argument(
        "--python",
        dest="native",
        action="store_false",
        help="all models in Python, where C has them as well",
    )
    add_json(parser, "the files")


def _build(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.engines import system_engines, why_python
    from cardsflow_fmu.simulation.build import SYSTEM_FILE, build

    experiment = experiment_of(options)
    files = build(
        experiment,
        options.output,
        fmi=options.fmi,
        arrays=not options.scalars,
        platforms=options.platforms,
        native=options.native,
    )
    if options.native is None:
        for model, what in why_python(experiment).items():
            print(f"cardsflow: {model}.fmu is in Python: C does not have {what}", file=sys.stderr)
    engines = ", ".join(f"{model} {engine}" for model, engine in system_engines(files).items())
    print(f"cardsflow: {engines}", file=sys.stderr)
    print_files((*files.values(), options.output / SYSTEM_FILE), options.json)
    return GOOD
