"""`cardsflow check`, `info`, `convert` and `size`: robots and their files."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import CardsflowError, Finding, InputError, RobotError
from addin_sdfusion.robot.finding import errors_first
from addin_sdfusion.robot.json_text import json_text

from .common import (
    FAILED,
    GOOD,
    ROBOT_FILE,
    add_cable_set,
    add_experiment,
    add_json,
    add_output,
    add_overwrite,
    add_robot,
    add_verbose,
    finding_lines,
    load_experiment,
    print_files,
    print_findings,
)
from .parser import Commands
from .results import convert_recording
from .terminal.messages import print_coloured
from .terminal.progress import show_progress

if TYPE_CHECKING:
    from addin_sdfusion.robot.formats.read import Reading
    from cardsflow_fmu.experiment.experiment import Experiment

_FORMATS = "sdf, gazebo, caspr, cardsflow, urdf, mjcf or osim"


def add_check(commands: Commands) -> None:
    """Add `check`."""
    parser = commands.add(
        "check",
        _check,
        "List errors and warnings about a robot or an experiment.",
        "cardsflow check examples/planar_2r/robot",
    )
    add_robot(parser, "; or an experiment.toml or the folder that contains it")
    add_json(parser, "the findings")
    add_verbose(parser)
    parser.add_argument(
        "--for",
        dest="format",
        metavar="FORMAT",
        help="also list the losses and errors of a conversion to this format: "
        f"{_FORMATS} (default: none)",
    )
    _add_repair(parser)
    parser.add_argument(
        "--motion",
        help="check a motion for muscles that collide with muscles or links: random, the name of a "
        "trajectory of the robot, or a .csv with joint positions, such as the results of a run "
        "(default: none)",
    )
    text = "minimum distance for --motion, in m (default: 0)"
    parser.add_argument("--clearance", type=float, default=0.0, metavar="X", help=text)
    parser.add_argument(
        "--capsules",
        type=float,
        metavar="RADIUS",
        help="use capsules of this radius for the links in --motion, in m (default: collision "
        "meshes)",
    )


def add_info(commands: Commands) -> None:
    """Add `info`."""
    parser = commands.add(
        "info",
        _info,
        "Show the contents of a robot, an FMU or an .ssp file.",
        "cardsflow info examples/planar_2r/robot --cable-set basic_multi_segment",
    )
    parser.add_argument("path", type=Path, help=f"{ROBOT_FILE}, an .fmu or an .ssp")
    add_cable_set(parser)
    add_json(parser)


def add_convert(commands: Commands) -> None:
    """Add `convert`."""
    parser = commands.add(
        "convert",
        _convert,
        "Convert a robot to another format, or results to a ROS 2 recording.",
        "cardsflow convert examples/planar_2r/robot --to mjcf -o planar_2r_mjcf",
        "It lists everything that the new format cannot represent.",
    )
    others = "; for --to FILE also the results of a run, a hardware.rec or a ROS 2 recording"
    add_robot(parser, others)
    parser.add_argument(
        "--to",
        required=True,
        metavar="FORMAT",
        help=f"new format: {_FORMATS} (caspr includes trajectories); or a file: muscles.csv for "
        "muscles of a robot, run.mcap for results, motion.csv for the joint states of a recording "
        "(required)",
    )
    add_output(parser, "folder for the robot (required for a format)", metavar="FOLDER")
    add_overwrite(parser)
    _add_repair(parser)
    add_json(parser, "files and findings")
    add_verbose(parser)


def add_size(commands: Commands) -> None:
    """Add `size`."""
    parser = commands.add(
        "size",
        _size,
        "Compute the muscle forces that the motion of an experiment needs.",
        "cardsflow size examples/planar_2r --margin 0.5",
        "It also lists the points of the motion that the muscles cannot hold.",
    )
    add_experiment(parser)
    text = "safety margin, as part of the peak force (default: 0.2)"
    parser.add_argument("--margin", type=float, default=0.2, metavar="X", help=text)
    add_json(parser)


def _add_repair(parser: argparse.ArgumentParser) -> None:
    text = "correct the known errors of published inertias (default: off)"
    parser.add_argument("--repair", action="store_true", help=text)


def _check(options: argparse.Namespace) -> int:
    from addin_sdfusion.robot.formats.read import read

    experiment = _experiment(options.robot)
    if experiment is None:
        reading = read(options.robot, options.cable_set, repair=options.repair)
        findings = list(reading.findings)
    else:
        parts = [(part.files[0], part.robot) for part in experiment.parts]
        parts = parts or [(experiment.robot_path, experiment.robot)]
        readings = [
            read(file, robot.cable_set or None, repair=options.repair) for file, robot in parts
        ]
        reading = readings[0]
        findings = [finding for one in readings for finding in one.findings]
    sound = not any(finding.is_error for finding in findings)
    failure = _start_error(experiment) if sound else None
    if sound and failure is None:
        findings += _drive_findings(reading, experiment)
        with show_progress("check"):
            findings += _motion_findings(options, reading)
        findings += _losses(options, reading)
        findings = errors_first(findings)
    if options.json:
        print(json_text([finding.as_dict() for finding in findings], indent=1))
    else:
        for _, line in finding_lines(findings, options.verbose):
            print_coloured(line)
    if failure is not None:
        raise failure
    if not options.json:
        errors = sum(finding.is_error for finding in findings)
        asked = {"--motion": options.motion, "--for": options.format}
        later = [] if sound else [option for option, value in asked.items() if value is not None]
        hint = f"; {' and '.join(later)} skipped because of the errors" if later else ""
        warnings = len(findings) - errors
        counts = f"{errors} error{'s' * (errors != 1)}, {warnings} warning{'s' * (warnings != 1)}"
        print(f"{counts}{hint}")
    return FAILED if any(finding.is_error for finding in findings) else GOOD


def _experiment(path: Path) -> Experiment | None:
    """Load the experiment of an experiment.toml or a folder; None for a robot."""
    from addin_sdfusion.robot.formats.read import holds_robot
    from cardsflow_fmu.experiment.experiment import Experiment

    inside = (path / "experiment.toml").is_file() and not holds_robot(path)
    return Experiment.load(path) if path.suffix in (".toml", ".json") or inside else None


def _start_error(experiment: Experiment | None) -> CardsflowError | None:
    """Return the error that would end a run of the experiment before its first step."""
    if experiment is None:
        return None
    from cardsflow_fmu.simulation.open import require_openable

    try:
        require_openable(experiment)
    except CardsflowError as error:
        return error
    return None


def _drive_findings(reading: Reading, experiment: Experiment | None) -> list[Finding]:
    """Return findings about motions and torques that the muscles cannot produce."""
    from cardsflow_fmu.results.analysis.drive_check import drive_findings, experiment_findings

    if experiment is not None:
        return experiment_findings(experiment)
    return drive_findings(reading.require())


def _motion_findings(options: argparse.Namespace, reading: Reading) -> list[Finding]:
    """Return collisions of muscles along the motion of --motion."""
    if options.motion is None:
        return []
    from cardsflow_fmu.results.analysis.motion_check import motion_findings

    robot = reading.require()
    return motion_findings(reading, robot, options.motion, options.clearance, options.capsules)


def _losses(options: argparse.Namespace, reading: Reading) -> list[Finding]:
    """Return findings about features that the format of --for cannot represent."""
    if options.format is None:
        return []
    from addin_sdfusion.robot.formats.convert import format_of, losses_in
    from addin_sdfusion.robot.formats.read import read_trajectories
    from addin_sdfusion.robot.formats.writing.carried_meshes import CarriedMeshes

    robot, file = reading.require(), reading.files[0]
    trajectories, findings = read_trajectories(file)
    meshes = CarriedMeshes.of(robot, file.parent)
    return [*findings, *losses_in(format_of(options.format, trajectories, meshes), robot)]


def _info(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.analysis.info import (
        describe_fmu,
        describe_robot,
        fmu_info,
        robot_info,
    )
    from cardsflow_fmu.simulation.ssp.info import describe_system, system_info

    if options.path.suffix == ".fmu":
        info, describe = fmu_info(options.path), describe_fmu
    elif options.path.suffix == ".ssp":
        info, describe = system_info(options.path), describe_system
    else:
        info, describe = robot_info(options.path, options.cable_set), describe_robot
    print(json_text(info, indent=1) if options.json else describe(info))
    return GOOD


def _convert(options: argparse.Namespace) -> int:
    from addin_sdfusion.robot.formats.convert import convert
    from addin_sdfusion.robot.formats.muscle_table.beside import MUSCLES_CSV
    from addin_sdfusion.robot.formats.read import read, read_trajectories
    from cardsflow_fmu.utils.folder_lock import create_folder

    if Path(options.to).suffix and Path(options.to).name != MUSCLES_CSV:
        return convert_recording(options)
    if Path(options.to).name == MUSCLES_CSV and options.output is None:
        options.to, options.output = MUSCLES_CSV, Path(options.to).parent
    if options.output is None:
        raise InputError("is required: the folder for the robot", key="--output")
    reading = read(options.robot, options.cable_set, repair=options.repair)
    findings = list(reading.findings)
    files: list[Path] = []
    failure: RobotError | None = None
    try:
        robot = reading.require()
        trajectories, unread = read_trajectories(reading.files[0])
        findings += unread
        with create_folder(options.output, "convert"), show_progress("convert"):
            files, lost = convert(
                robot,
                options.to,
                options.output,
                trajectories,
                mesh_folder=reading.files[0].parent,
                sources=reading.files,
                overwrite=options.overwrite,
            )
        findings += lost
    except RobotError as error:
        findings += [finding for finding in error.findings if finding not in findings]
        failure = error
    if not options.json:
        print_findings(findings, options.verbose)
    print_files(files, options.json, findings=[finding.as_dict() for finding in findings])
    if failure is not None:
        raise failure
    return GOOD


def _size(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.analysis.sizing import size
    from cardsflow_fmu.results.analysis.sizing_report import describe_sizes

    with show_progress("size"):
        sizes = size(load_experiment(options), margin=options.margin)
    print(json_text(sizes, indent=1) if options.json else describe_sizes(sizes))
    return FAILED if sizes["impossible_points"] else GOOD
