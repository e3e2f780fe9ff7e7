"""`cardsflow run`: an experiment, or the FMUs of an .ssp file, with hardware or without."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError

from .cli_parts import GOOD, add_command, add_experiment, experiment_of, settings_of
from .cli_view import add_live_options, refuse_view, watched

if TYPE_CHECKING:
    from .master import Progress
    from .results import SystemResult


def add_run(commands: Any, common: argparse.ArgumentParser, started: float) -> None:
    """Add `run`.

    Args:
        commands: Where to.
        common: Options that all commands have.
        started: `time.perf_counter()` at the start of the program.
    """
    parser = add_command(
        commands,
        common,
        "run",
        "Build the FMUs of an experiment, or take those of an .ssp file; co-simulate them; "
        "write results and a figure.",
        "cardsflow run examples/planar_2r --set controller.period=0.01 -o at_100_hz",
    )
    add_experiment(parser, "; or an .ssp file")
    parser.add_argument("-o", "--output", type=Path, help="folder for the results")
    parser.add_argument(
        "--direct", action="store_true", help="step plain Python objects instead of FMUs"
    )
    parser.add_argument(
        "--hardware",
        metavar="URI",
        help="drive hardware instead of the plant, such as udp://127.0.0.1:5005",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="let steps wait for their time by the clock"
    )
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")
    parser.add_argument(
        "--view", action="store_true", help="show the run in the browser while it goes on"
    )
    add_live_options(parser)
    parser.set_defaults(command=partial(_run, started))


def _run(started: float, options: argparse.Namespace) -> int:
    if options.experiment.suffix == ".ssp":
        return _run_system(started, options)
    from .simulation import RunError, Through, run

    if options.hardware is not None:
        options.set += [f"hardware.link={json.dumps(options.hardware)}", "hardware.use=true"]
    experiment = experiment_of(options)
    if experiment.hardware.use:
        _require_address(experiment.hardware.link)
    for warning in experiment.warnings():
        print(f"cardsflow: warning: {warning}", file=sys.stderr)
    through: Through = "direct" if options.direct else "fmu"
    try:
        with watched(experiment, options) as (watch, replay):
            with _progress_bar(experiment.run.steps) as progress:
                result = run(
                    experiment,
                    options.output,
                    through=through,
                    realtime=options.realtime,
                    progress=progress,
                    watch=watch,
                    started=started,
                )
            _print_result(result, options.json)
            replay(result)
    except RunError as error:
        _print_result(error.result, options.json)
        raise
    return GOOD


def _require_address(link: str) -> None:
    """Refuse an address that none of the links understands, before anything is built.

    Raises:
        InputError: It is one.
    """
    from .hardware.link import open_link

    if link and not link.startswith(("loopback:", "emulated:")):
        open_link(link)


def _run_system(started: float, options: argparse.Namespace) -> int:
    from .hardware.opening import environment
    from .hardware.settings import HardwareSettings
    from .system_run import SystemRunError, run_system

    refuse_view(options, "the robot of an .ssp is not known")
    if options.direct:
        raise InputError("holds FMUs, which --direct cannot do without", file=options.experiment)
    settings = settings_of(options.set)
    if options.hardware is not None:
        _require_address(options.hardware)
        settings["variant"] = "hardware"
    try:
        with environment(HardwareSettings(link=options.hardware or "")):
            result = run_system(
                options.experiment,
                options.output,
                settings,
                realtime=options.realtime,
                started=started,
            )
    except SystemRunError as error:
        _print_result(error.result, options.json)
        raise
    _print_result(result, options.json)
    return GOOD


@contextmanager
def _progress_bar(steps: int) -> Iterator[Progress | None]:
    """A progress bar on a terminal, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield None
        return
    from tqdm import tqdm

    with tqdm(total=steps, unit="step", leave=False) as bar:

        def show(done: int) -> None:
            bar.update(done - bar.n)

        yield show


def _print_result(result: SystemResult, as_json: bool) -> None:
    if as_json:
        print(json.dumps(result.summary, indent=1))
    else:
        print(result.describe())
