"""`cardsflow build`: the FMUs of an experiment."""

from __future__ import annotations

import argparse

from .common import GOOD, Commands, add_experiment, add_json, add_output, experiment_of, print_files


def add_build(commands: Commands) -> None:
    """Add `build`."""
    parser = commands.add(
        "build",
        _build,
        "Build plant, controller, reference and hardware.fmu of an experiment, and system.ssp.",
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
    parser.add_argument(
        "--native",
        action="store_true",
        help="plant, controller and reference in C alone: they need no Python where they run",
    )
    add_json(parser, "the files")


def _build(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.build import SYSTEM_FILE, build

    files = build(
        experiment_of(options),
        options.output,
        fmi=options.fmi,
        arrays=not options.scalars,
        platforms=options.platforms,
        native=options.native,
    )
    print_files((*files.values(), options.output / SYSTEM_FILE), options.json)
    return GOOD
