"""`cardsflow run` and `build`: experiments, .ssp files, hardware, and FMUs."""

from __future__ import annotations

import argparse
import shlex
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text

from .common import (
    DOUBTFUL,
    FAILED,
    GOOD,
    add_experiment,
    add_json,
    add_output,
    add_verbose,
    load_experiment,
    parse_settings,
    print_files,
    print_findings,
    print_result,
)
from .parser import Commands
from .terminal.messages import print_error, print_note, print_warning
from .terminal.progress import show_progress
from .view import add_live_options, live_watch, reject_view

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.simulation.result import SystemResult


def add_run(commands: Commands) -> None:
    """Add `run`; the option `started` is `time.perf_counter()` at the start of the program."""
    parser = commands.add(
        "run",
        _run,
        "Simulate an experiment or an .ssp file; write the results.",
        "cardsflow run examples/planar_2r --set controller.period=0.01 -o at_100_hz",
        "The FMUs of an experiment are built first.",
    )
    add_experiment(parser, "; or an .ssp file")
    text = "folder for the results (default: `results` next to the experiment)"
    add_output(parser, text, metavar="FOLDER")
    add_verbose(parser, "print every signal (default: the worst signal of each kind)")
    parser.add_argument(
        "--compute",
        choices=("c", "python"),
        help="engine of the models: C where available, or Python (default: run.compute of the "
        "experiment)",
    )
    text = "couple FMUs, or the models directly (default: run.coupling of the experiment)"
    parser.add_argument("--coupling", choices=("fmu", "direct"), help=text)
    parser.add_argument(
        "--hardware",
        metavar="URI",
        help="drive hardware instead of the simulated plant, such as udp://127.0.0.1:5005 "
        "(default: hardware.use and hardware.link of the experiment)",
    )
    parser.add_argument(
        "--realtime", action="store_true", help="run in real time (default: as fast as possible)"
    )
    parser.add_argument(
        "--figures",
        action="store_true",
        help="draw figures of the run: run.figures = true (default: run.figures of the experiment; "
        "`cardsflow plot` draws later)",
    )
    parser.add_argument(
        "--strict", action="store_true", help="exit with 3 if the run has warnings (default: off)"
    )
    text = 'do not fail if the reference is not tracked: run.accept = "any" (default: off)'
    parser.add_argument("--allow-poor-tracking", action="store_true", help=text)
    add_json(parser, "the summary")
    text = "show the simulation in the browser during the run (default: off)"
    parser.add_argument("--view", action="store_true", help=text)
    add_live_options(parser)
    parser.add_argument(
        "--publish",
        metavar="URI",
        help="publish the run as ROS 2 topics in real time: ros2://NAMESPACE?domain=N&node=NAME "
        "(default: none)",
    )


def _run(options: argparse.Namespace) -> int:
    if options.experiment.suffix == ".ssp":
        return _run_system(options)
    from cardsflow_fmu.results.analysis.plausibility import plausibility_findings
    from cardsflow_fmu.simulation.open import require_openable
    from cardsflow_fmu.simulation.run import RunError, run

    if options.hardware is not None:
        options.set += [f"hardware.link={json_text(options.hardware)}", "hardware.use=true"]
    options.set += [f"run.{key}={value}" for key, value in _engine(options).items()]
    options.set += _accept(options)
    options.set += ["run.figures=true"] if options.figures else []
    experiment = load_experiment(options)
    if experiment.hardware.use:
        from cardsflow_fmu.hardware.session.connect import require_connectable

        require_connectable(experiment)  # fails before the FMUs are built
    for warning in experiment.warnings():
        print_warning(warning)
    if findings := plausibility_findings(experiment):
        require_openable(experiment)  # an error is reported without warnings before it
        print_findings(findings, rest="cardsflow check")
    _print_observability(experiment)
    try:
        with live_watch(experiment, options) as (watch, replay):
            with show_progress("run", "steps") as update:
                steps = experiment.run.steps
                result = run(
                    experiment,
                    options.output,
                    realtime=options.realtime or options.publish is not None,
                    progress=lambda done: update(done, steps),
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
    """Print a note about unobservable poses of the reference."""
    if experiment.estimator is None:
        return
    from cardsflow_fmu.results.analysis import observable

    poses = observable.observed_poses(experiment)
    for line in observable.observability_warnings(poses):
        print_warning(line)
    for line in observable.observability_notes(poses):
        print_note(f"note: {line}")


def _run_system(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.run import RunError, run_system

    reject_view(options, "is only for experiments; run the .ssp, then view its results")
    if engine := _engine(options):
        problem = f"contains built FMUs; --{next(iter(engine))} is only for experiments"
        raise InputError(problem, file=options.experiment)
    if options.figures:
        raise InputError("is only for experiments; plot the results", key="--figures")
    settings = parse_settings([*options.set, *_accept(options)])
    if options.hardware is not None:
        # hardware.fmu creates the device of a loopback or an emulator itself
        if not options.hardware.startswith(("loopback:", "emulated:")):
            from cardsflow_fmu.hardware.session.open_link import open_link

            open_link(options.hardware)  # raises an error for an invalid URI
        settings["variant"] = "hardware"
    try:
        with show_progress("run", "steps") as update:
            result = run_system(
                options.experiment,
                options.output,
                settings,
                hardware=options.hardware or "",
                realtime=options.realtime,
                progress=lambda done: update(done, 0),
                started=options.started,
            )
    except RunError as error:
        _print_result(error.result, options)
        raise
    _print_result(result, options)
    return _code(result, options)


def _accept(options: argparse.Namespace) -> list[str]:
    return ["run.accept=any"] if options.allow_poor_tracking else []


def _engine(options: argparse.Namespace) -> dict[str, str]:
    """Return the settings of `run` that --compute and --coupling specify."""
    settings = {"compute": options.compute, "coupling": options.coupling}
    return {key: value for key, value in settings.items() if value is not None}


def _print_result(result: SystemResult, options: argparse.Namespace) -> None:
    if options.json:
        from cardsflow_fmu.results.verdict import failure_text

        print(json_text(result.summary, indent=1))
        if (failed := failure_text(result.summary)) is not None:
            print_error(failed)
        return
    from cardsflow_fmu.results.files import EXPERIMENT

    print_result(result.describe(every=options.verbose))
    archive = result.files.get(EXPERIMENT)
    if archive is not None:
        print(f"next        cardsflow view {shlex.quote(str(archive.parent))}")


def _code(result: SystemResult, options: argparse.Namespace) -> int:
    if result.summary["status"] == "failed":
        return FAILED
    return DOUBTFUL if options.strict and result.summary["warnings"] else GOOD


def add_build(commands: Commands) -> None:
    """Add `build`."""
    parser = commands.add(
        "build",
        _build,
        "Build the FMUs of an experiment, and system.ssp.",
        "cardsflow build examples/planar_2r -o fmus",
        "The FMUs are plant, controller, reference and hardware.fmu; also sensors and "
        "estimator.fmu if the experiment has an estimator.",
    )
    add_experiment(parser)
    add_output(parser, "folder for the FMUs", required=True, metavar="FOLDER")
    text = "FMI version; system.ssp always contains FMUs of FMI 2.0 (default: 2.0)"
    parser.add_argument("--fmi", choices=("2.0", "3.0"), default="2.0", help=text)
    parser.add_argument(
        "--kind",
        choices=("cs", "me"),
        default="cs",
        help="cs for co-simulation; me for model exchange: plant.fmu in continuous time for the "
        "solver of another tool (default: cs)",
    )
    text = "use scalar variables in FMI 3.0, for tools without arrays (default: arrays)"
    parser.add_argument("--scalars", action="store_true", help=text)
    parser.add_argument(
        "--platforms",
        type=lambda text: text.split(","),
        metavar="NAME,...",
        help="platforms of the FMUs: linux64, win64, darwin64, aarch64-linux, ...; platforms "
        "without a prebuilt library need the extra `cross` (default: this platform, and every "
        "prebuilt one for FMUs in C)",
    )
    parser.add_argument(
        "--compute",
        choices=("c", "python"),
        help="engine of the models: c requires C in every FMU, so that they run without Python; "
        "python uses a Python process in every FMU (default: C where available)",
    )
    parser.add_argument(
        "--results",
        action="store_true",
        help="add reference results to the FMUs, with which other tools compare theirs "
        "(default: none)",
    )
    add_json(parser, "the file names")


def _build(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.engines import python_reasons, system_engines
    from cardsflow_fmu.simulation.build import SYSTEM_FILE, build

    experiment = load_experiment(options)
    with show_progress("build"):
        files = build(
            experiment,
            options.output,
            fmi=options.fmi,
            arrays=not options.scalars,
            platforms=options.platforms,
            compute=options.compute,
            kind=options.kind,
            with_results=options.results,
        )
    if options.kind == "me":
        print_note("plant.fmu is for model exchange; the other models are sampled: use --kind cs")
        print_files(files.values(), options.json)
        return GOOD
    if options.compute is None:
        for model, feature in python_reasons(experiment).items():
            print_note(f"{model}.fmu uses Python; the C engine does not support {feature}")
    engines = ", ".join(f"{model} {engine}" for model, engine in system_engines(files).items())
    print_note(f"engines: {engines}")
    print_files((*files.values(), options.output / SYSTEM_FILE), options.json)
    return GOOD
