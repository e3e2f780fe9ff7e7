"""The command line: parses, and calls public functions."""

from __future__ import annotations

import time

_STARTED = time.perf_counter()

import argparse  # noqa: E402
import json  # noqa: E402
import os  # noqa: E402
import sys  # noqa: E402
import traceback  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

from addin_sdfusion.robot import CardsflowError, InputError, RobotError  # noqa: E402
from cardsflow_fmu.utils import interrupts  # noqa: E402
from cardsflow_fmu.version import __version__  # noqa: E402

from .addin import add_addin  # noqa: E402
from .common import (  # noqa: E402
    BAD_INPUT,
    EXIT_CODES,
    FAILED,
    GOOD,
    INTERRUPTED,
    add_command,
    add_experiment,
    add_json,
    experiment_of,
    print_files,
)
from .device import add_hardware  # noqa: E402
from .init import add_start  # noqa: E402
from .results import add_results  # noqa: E402
from .run import add_run  # noqa: E402
from .study import add_study  # noqa: E402
from .view import add_view  # noqa: E402


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        arguments: Words after `cardsflow`; the process' own when None.

    Returns:
        The exit code; see `EXIT_CODES`.
    """
    try:
        with interrupts.terminable():
            return _run(_parser().parse_args(arguments))
    except KeyboardInterrupt:
        print(f"cardsflow: {interrupts.INTERRUPTED}", file=sys.stderr)
        return INTERRUPTED


def _run(options: argparse.Namespace) -> int:
    try:
        code = int(options.command(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # whoever reads the output has read enough, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return GOOD
    except Exception as error:
        if options.debug:
            traceback.print_exc()
        if isinstance(error, OSError):
            print(f"cardsflow: {error.strerror or error}", file=sys.stderr)
            return FAILED
        if isinstance(error, CardsflowError):
            print(f"cardsflow: {error}", file=sys.stderr)
            return _code_of(error)
        what = f"{type(error).__name__}: {error}"
        print(f"cardsflow: internal error: {what} (--debug shows where)", file=sys.stderr)
        return FAILED


def _code_of(error: CardsflowError) -> int:
    if isinstance(error, InputError):
        return BAD_INPUT
    reason = str(error).partition(";")[0]
    return INTERRUPTED if reason == interrupts.INTERRUPTED else FAILED


def _parser() -> argparse.ArgumentParser:
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--debug", action="store_true", help="show the trace of an error")
    parser = argparse.ArgumentParser(
        prog="cardsflow",
        description="Cable-driven robots: simulate, control, package as FMUs.",
        epilog=f"example:\n  cardsflow run examples/planar_2r -o results\n\n{EXIT_CODES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"cardsflow {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    add_start(commands, common, parser)
    add_run(commands, common, _STARTED)
    _add_build(commands, common)
    _add_check(commands, common)
    _add_info(commands, common)
    _add_convert(commands, common)
    _add_size(commands, common)
    add_hardware(commands, common)
    add_addin(commands, common)
    add_view(commands, common)
    add_results(commands, common)
    add_study(commands, common)
    return parser


def _add_build(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "build",
        "Build plant, controller, reference and hardware.fmu of an experiment, and system.ssp.",
        "cardsflow build examples/planar_2r -o fmus",
    )
    add_experiment(parser)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the FMUs")
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
    parser.set_defaults(command=_build)


def _add_size(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "size",
        "Say how strong each muscle must be for an experiment's motion, and what is in the way.",
        "cardsflow size examples/planar_2r --margin 0.5",
    )
    add_experiment(parser)
    parser.add_argument(
        "--margin", type=float, default=0.2, help="part of the peak to add to it; 0.2"
    )
    parser.add_argument("--json", action="store_true", help="print it as JSON")
    parser.set_defaults(command=_size)


def _add_check(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "check",
        "List everything that is wrong or doubtful in a robot's files.",
        "cardsflow check examples/planar_2r/robot",
    )
    parser.add_argument("robot", type=Path, help="a model.sdf, a *_bodies.xml, or their folder")
    parser.add_argument("--cable-set", help="the cable set to use; the file's own when left out")
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")
    parser.add_argument(
        "--motion",
        help="look for muscles that meet one another or links: random, the name of a trajectory "
        "beside the robot, or a .csv with the joints' positions, such as a run's results",
    )
    parser.add_argument(
        "--clearance", type=float, default=0.0, help="smallest distance wanted, in m; 0"
    )
    parser.add_argument(
        "--capsules",
        type=float,
        metavar="RADIUS",
        help="capsules of this radius, in m, stand for the links, not their collision meshes",
    )
    parser.set_defaults(command=_check)


def _add_info(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "info",
        "Show what a robot, an FMU or a system of FMUs is made of.",
        "cardsflow info examples/planar_2r/robot --cable-set basic_multi_segment",
    )
    parser.add_argument(
        "thing", type=Path, help="a model.sdf, a *_bodies.xml, their folder, an .fmu or an .ssp"
    )
    parser.add_argument("--cable-set", help="the cable set to use; the file's own when left out")
    parser.add_argument("--json", action="store_true", help="print it as JSON")
    parser.set_defaults(command=_info)


def _add_convert(commands: Any, common: argparse.ArgumentParser) -> None:
    parser = add_command(
        commands,
        common,
        "convert",
        "Write a robot in another format, and say what that cannot hold.",
        "cardsflow convert examples/planar_2r/robot --to mjcf -o planar_2r_mjcf",
    )
    parser.add_argument("robot", type=Path, help="a model.sdf, a *_bodies.xml, or their folder")
    parser.add_argument(
        "--to", required=True, metavar="FORMAT", help="sdf, caspr, cardsflow, urdf, mjcf or osim"
    )
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the files")
    parser.add_argument("--cable-set", help="the cable set to use; the file's own when left out")
    parser.add_argument(
        "--repair", action="store_true", help="undo the known defects of published inertias"
    )
    add_json(parser, "files and findings")
    parser.set_defaults(command=_convert)


def _build(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.run import SYSTEM_FILE, build

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


def _size(options: argparse.Namespace) -> int:
    from cardsflow_fmu.analysis.sizing import size
    from cardsflow_fmu.analysis.sizing_report import describe_sizes

    sizes = size(experiment_of(options), margin=options.margin)
    print(json.dumps(sizes, indent=1) if options.json else describe_sizes(sizes))
    return FAILED if sizes["impossible_points"] else GOOD


def _check(options: argparse.Namespace) -> int:
    from addin_sdfusion.robot.readers import read

    try:
        reading = read(options.robot, options.cable_set)
        findings = reading.findings
    except RobotError as error:
        findings = error.findings
    else:
        if options.motion is not None:
            from cardsflow_fmu.analysis.motion_check import motion_findings

            findings += tuple(
                motion_findings(
                    reading, reading.require(), options.motion, options.clearance, options.capsules
                )
            )
    if options.json:
        print(json.dumps([finding.as_dict() for finding in findings], indent=1))
    else:
        for finding in findings:
            print(finding)
        errors = sum(finding.is_error for finding in findings)
        print(f"{errors} errors, {len(findings) - errors} warnings")
    return FAILED if any(finding.is_error for finding in findings) else GOOD


def _info(options: argparse.Namespace) -> int:
    from cardsflow_fmu.analysis.info import describe_fmu, describe_robot, fmu_info, robot_info
    from cardsflow_fmu.ssp.info import describe_system, system_info

    if options.thing.suffix == ".fmu":
        info, describe = fmu_info(options.thing), describe_fmu
    elif options.thing.suffix == ".ssp":
        info, describe = system_info(options.thing), describe_system
    else:
        info, describe = robot_info(options.thing, options.cable_set), describe_robot
    print(json.dumps(info, indent=1) if options.json else describe(info))
    return GOOD


def _convert(options: argparse.Namespace) -> int:
    from addin_sdfusion.robot.readers import read
    from addin_sdfusion.robot.writers.convert import convert

    reading = read(options.robot, options.cable_set, repair=options.repair)
    robot = reading.require()
    conversion = convert(robot, options.to, options.output)
    findings = (*reading.findings, *conversion.findings)
    if not options.json:
        for finding in findings:
            print(finding, file=sys.stderr)
    told = [finding.as_dict() for finding in findings]
    print_files(conversion.files, options.json, findings=told)
    return GOOD
