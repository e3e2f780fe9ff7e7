"""`cardsflow run` and `build`: experiments, the FMUs of an .ssp file, hardware, and FMUs alone."""

from __future__ import annotations

import argparse
import shlex
import sys
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text

from .common import (
    DOUBTFUL,
    GOOD,
    Commands,
    add_experiment,
    add_json,
    add_output,
    add_verbose,
    experiment_of,
    print_files,
    print_result,
    refuse_flags,
    settings_of,
)
from .progress import progress_bar
from .view import add_live_options, refuse_view, watched

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.simulation.result import SystemResult

_INSTEAD = "give --compute c or python, and --coupling fmu or direct"


def add_run(commands: Commands) -> None:
    """Add `run`; its options have `started`, `time.perf_counter()` at the start of the program."""
    parser = commands.add(
        "run",
        _run,
        "Build the FMUs of an experiment, or take those of an .ssp file; co-simulate them; "
        "write results and a figure.",
        "cardsflow run examples/planar_2r --set controller.period=0.01 -o at_100_hz",
    )
    add_experiment(parser, "; or an .ssp file")
    add_output(parser, "folder for the results")
    add_verbose(parser, "print every signal, not the worst of each kind")
    parser.add_argument(
        "--compute",
        choices=("c", "python"),
        help="who computes: C wherever C can, or models that a Python process hosts; "
        "run.compute of the experiment when left out",
    )
    parser.add_argument(
        "--coupling",
        choices=("fmu", "direct"),
        help="FMUs, or the models directly, in one loop in C where all of them compute in C; "
        "run.coupling of the experiment when left out",
    )
    refuse_flags(parser, ("--direct", "--native", "--python"), _INSTEAD)
    parser.add_argument(
        "--hardware",
        metavar="URI",
        help="drive hardware instead of the plant, such as udp://127.0.0.1:5005",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="let steps wait for their time by the clock"
    )
    parser.add_argument(
        "--strict", action="store_true", help="exit with 3 where the run has warnings"
    )
    add_json(parser, "the summary")
    parser.add_argument(
        "--as-script",
        action="store_true",
        help="print the Python that does it, in plain FMPy where FMUs are stepped; run nothing",
    )
    parser.add_argument(
        "--view", action="store_true", help="show the run in the browser while it goes on"
    )
    add_live_options(parser)
    parser.add_argument(
        "--publish",
        metavar="URI",
        help="publish the run as topics of ROS 2 while it goes on, in real time: "
        "ros2://NAMESPACE?domain=N&node=NAME",
    )


def _run(options: argparse.Namespace) -> int:
    if options.experiment.suffix == ".ssp":
        return _run_system(options)
    from cardsflow_fmu.simulation.run import RunError, run

    if options.hardware is not None:
        options.set += [f"hardware.link={json_text(options.hardware)}", "hardware.use=true"]
    options.set += [f"run.{key}={value}" for key, value in _engine(options).items()]
    experiment = experiment_of(options)
    if experiment.hardware.use:
        from cardsflow_fmu.hardware.session.connect import require_connectable

        require_connectable(experiment)  # before anything is built
    for warning in experiment.warnings():
        print(f"cardsflow: warning: {warning}", file=sys.stderr)
    _print_observability(experiment)
    if options.as_script:
        return _print_script(options, experiment)
    try:
        with watched(experiment, options) as (watch, replay):
            with progress_bar(experiment.run.steps) as progress:
                result = run(
                    experiment,
                    options.output,
                    realtime=options.realtime or options.publish is not None,
                    progress=progress,
                    watch=watch,
                    started=options.started,
                )
            _print_result(result, options)
            replay(result)
    except RunError as error:
        _print_result(error.result, options)
        raise
    return _code(result, options)


def _print_observability(experiment: Experiment) -> None:
    """What an estimator can tell of the reference's poses."""
    if experiment.estimator is None:
        return
    from cardsflow_fmu.results.analysis import observable

    found = observable.observed_poses(experiment)
    for line in observable.observability_warnings(found):
        print(f"cardsflow: warning: {line}", file=sys.stderr)
    for line in observable.observability_remarks(found):
        print(f"cardsflow: note: {line}", file=sys.stderr)


def _run_system(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.run import RunError, run_system

    refuse_view(options, "is for experiments; run the .ssp, and then view its results")
    if engine := _engine(options):
        what = f"holds FMUs, which --{next(iter(engine))} cannot change or do without"
        raise InputError(what, file=options.experiment)
    settings = settings_of(options.set)
    if options.hardware is not None:
        if not options.hardware.startswith(
            ("loopback:", "emulated:")
        ):  # whose device hardware.fmu makes
            from cardsflow_fmu.hardware.session.open_link import open_link

            open_link(options.hardware)  # is refused where no link understands it
        settings["variant"] = "hardware"
    if options.as_script:
        if options.hardware is not None:
            what = "is not in a script of an .ssp; give run_system its argument `hardware`"
            raise InputError(what, key="--hardware")
        return _print_script(options)
    try:
        with progress_bar() as progress:
            result = run_system(
                options.experiment,
                options.output,
                settings,
                hardware=options.hardware or "",
                realtime=options.realtime,
                progress=progress,
                started=options.started,
            )
    except RunError as error:
        _print_result(error.result, options)
        raise
    _print_result(result, options)
    return _code(result, options)


def _engine(options: argparse.Namespace) -> dict[str, str]:
    """Who computes and how they are coupled, where the options say."""
    given = {"compute": options.compute, "coupling": options.coupling}
    return {key: value for key, value in given.items() if value is not None}


def _print_script(options: argparse.Namespace, experiment: Experiment | None = None) -> int:
    from .run_script import fmpy_script, missing_in_fmpy, run_script

    refuse_view(options, "is not in a script; leave it out")
    path, output = options.experiment, options.output
    if experiment is not None and experiment.run.coupling == "fmu":
        missing = missing_in_fmpy(experiment, options.realtime)
        if missing is None:
            python, hardware = experiment.run.compute == "python", experiment.hardware.use
            print(fmpy_script(path, output, options.set, python=python, hardware=hardware), end="")
            return GOOD
        what = f"{missing} is not in the script in plain FMPy; this one is by cardsflow_fmu"
        print(f"cardsflow: warning: {what}", file=sys.stderr)
    settings = settings_of(options.set)
    print(run_script(path, output, settings, realtime=options.realtime), end="")
    return GOOD


def _print_result(result: SystemResult, options: argparse.Namespace) -> None:
    if options.json:
        print(json_text(result.summary, indent=1))
        return
    from cardsflow_fmu.results.files import EXPERIMENT

    print_result(result.describe(every=options.verbose))
    archive = result.files.get(EXPERIMENT)
    if archive is not None:
        print(f"next        cardsflow view {shlex.quote(str(archive.parent))}")


def _code(result: SystemResult, options: argparse.Namespace) -> int:
    return DOUBTFUL if options.strict and result.summary["warnings"] else GOOD


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
    parser.add_argument(
        "--compute",
        choices=("c", "python"),
        help="who computes: c in all FMUs, which need no Python where they run, or nothing is "
        "built; python in none, a Python process hosts the models; c in those that can when left "
        "out",
    )
    refuse_flags(parser, ("--native", "--python"), "give --compute c or --compute python")
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
        compute=options.compute,
    )
    if options.compute is None:
        for model, what in why_python(experiment).items():
            print(f"cardsflow: {model}.fmu is in Python: C does not have {what}", file=sys.stderr)
    engines = ", ".join(f"{model} {engine}" for model, engine in system_engines(files).items())
    print(f"cardsflow: {engines}", file=sys.stderr)
    print_files((*files.values(), options.output / SYSTEM_FILE), options.json)
    return GOOD
