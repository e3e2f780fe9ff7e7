"""`cardsflow check`, `info`, `convert` and `size`: robots and their files."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from addin_sdfusion.robot import RobotError

from .common import (
    FAILED,
    GOOD,
    Commands,
    add_cable_set,
    add_experiment,
    add_json,
    add_output,
    add_robot,
    experiment_of,
    print_files,
    print_findings,
)


def add_check(commands: Commands) -> None:
    """Add `check`."""
    parser = commands.add(
        "check",
        _check,
        "List everything that is wrong or doubtful in a robot's files.",
        "cardsflow check examples/planar_2r/robot",
    )
    add_robot(parser)
    add_json(parser, "the findings")
    parser.add_argument(
        "--motion",
        help="look for muscles that meet one another or links: random, the name of a trajectory "
        "beside the robot, or a .csv with the joints' positions, such as a run's results",
    )
    parser.add_argument(
        "--clearance", type=float, default=0.0, help="smallest distance allowed, in m; 0"
    )
    parser.add_argument(
        "--capsules",
        type=float,
        metavar="RADIUS",
        help="take capsules of this radius, in m, for the links instead of their collision meshes",
    )


def add_info(commands: Commands) -> None:
    """Add `info`."""
    parser = commands.add(
        "info",
        _info,
        "Show what a robot, an FMU or a system of FMUs is made of.",
        "cardsflow info examples/planar_2r/robot --cable-set basic_multi_segment",
    )
    parser.add_argument(
        "thing", type=Path, help="a model.sdf, a *_bodies.xml, their folder, an .fmu or an .ssp"
    )
    add_cable_set(parser)
    add_json(parser)


def add_convert(commands: Commands) -> None:
    """Add `convert`."""
    parser = commands.add(
        "convert",
        _convert,
        "Write a robot in another format, and say what that cannot hold.",
        "cardsflow convert examples/planar_2r/robot --to mjcf -o planar_2r_mjcf",
    )
    add_robot(parser)
    parser.add_argument(
        "--to", required=True, metavar="FORMAT", help="sdf, caspr, cardsflow, urdf, mjcf or osim"
    )
    add_output(parser, "folder for the files", required=True)
    parser.add_argument(
        "--repair", action="store_true", help="undo the known defects of published inertias"
    )
    add_json(parser, "files and findings")


def add_size(commands: Commands) -> None:
    """Add `size`."""
    parser = commands.add(
        "size",
        _size,
        "Say how strong each muscle must be for an experiment's motion, and what is in the way.",
        "cardsflow size examples/planar_2r --margin 0.5",
    )
    add_experiment(parser)
    parser.add_argument(
        "--margin", type=float, default=0.2, help="part of the peak to add to it; 0.2"
    )
    add_json(parser)


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
        print_findings(findings)
    data = [finding.as_dict() for finding in findings]
    print_files(conversion.files, options.json, findings=data)
    return GOOD


def _size(options: argparse.Namespace) -> int:
    from cardsflow_fmu.analysis.sizing import size
    from cardsflow_fmu.analysis.sizing_report import describe_sizes

    sizes = size(experiment_of(options), margin=options.margin)
    print(json.dumps(sizes, indent=1) if options.json else describe_sizes(sizes))
    return FAILED if sizes["impossible_points"] else GOOD
