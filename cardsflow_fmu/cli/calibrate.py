"""`cardsflow excite` and `calibrate`: parameters of a robot from recordings."""

from __future__ import annotations

import argparse
from pathlib import Path

from addin_sdfusion.robot import InputError

from .common import (
    GOOD,
    ROBOT_FILE,
    add_cable_set,
    add_json,
    add_output,
    add_robot,
    add_verbose,
    add_words,
    print_files,
    print_findings,
    print_result,
)
from .parser import Commands
from .terminal.progress import show_progress

_PARAMETERS = (
    "muscles.*.offset, .via_points, .stiffness, .friction; links.*.inertia; "
    "joints.*.damping, .friction; motors.*.gain, .armature; delays.tensions, delays.lengths"
)


def add_excite(commands: Commands) -> None:
    """Add `excite`."""
    parser = commands.add(
        "excite",
        _excite,
        "Design a motion that identifies the parameters of a robot.",
        'cardsflow excite robot --parameters "muscles.*.offset, muscles.*.via_points" -o exciting',
        "The motion is written as an experiment to run and record. The report lists the parameters "
        "that a recording does not identify.",
    )
    add_robot(parser)
    add_words(
        parser,
        "--parameters",
        "PATTERN",
        f"parameters to identify: {_PARAMETERS} (default: offsets, via points, inertias and "
        "damping)",
    )
    text = "duration of the motion, in s (default: 20)"
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help=text)
    text = "maximum joint speed, in rad/s (default: 1.5)"
    parser.add_argument("--speed", type=float, default=1.5, metavar="V", help=text)
    text = "folder for the experiment, new or empty"
    add_output(parser, text, required=True, metavar="FOLDER")
    add_json(parser, "the file names")
    add_verbose(parser)


def add_calibrate(commands: Commands) -> None:
    """Add `calibrate`."""
    parser = commands.add(
        "calibrate",
        _calibrate,
        "Calibrate the parameters of a robot from recordings.",
        "cardsflow calibrate results/hardware.rec --robot robot "
        '--parameters "muscles.*.offset, joints.*.damping" -o calibrated',
        "The report lists the parameters that are not identifiable.",
    )
    parser.add_argument(
        "recordings",
        type=Path,
        nargs="+",
        metavar="RECORDING",
        help="a hardware.rec, the folder of a run, or a table with time, q.*, l.*, f.*; the last "
        "recording, or the end of a single one, is held out to check the result",
    )
    parser.add_argument("--robot", type=Path, required=True, help=f"{ROBOT_FILE} (required)")
    add_cable_set(parser)
    text = f"parameters to calibrate: {_PARAMETERS}; markers.*.position (required)"
    add_words(parser, "--parameters", "PATTERN", text)
    parser.add_argument(
        "--markers",
        type=Path,
        metavar="FILE",
        help="motion-capture markers on the robot: a TOML table with link and position for each "
        "(default: none)",
    )
    parser.add_argument(
        "--capture",
        type=Path,
        action="append",
        default=[],
        metavar="CSV",
        help="recorded marker positions: columns time, MARKER.x, .y, .z, in m in the world frame; "
        "repeat it for each recording without such columns (default: none)",
    )
    text = "folder for the calibrated robot and the report, new or empty"
    add_output(parser, text, required=True, metavar="FOLDER")
    add_json(parser, "the file names")
    add_verbose(parser)


def _excite(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.excite import excite

    with show_progress("excite") as update:
        done = excite(
            options.robot,
            options.parameters,
            options.output,
            options.cable_set,
            options.duration,
            options.speed,
            progress=update,
        )
    if not options.json:
        print_findings(done.findings, options.verbose)
        print_result(done.text)
    print_files(done.files, options.json)
    return GOOD


def _calibrate(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.calibration import calibrate_files

    if not options.parameters:
        raise InputError('is required, such as "muscles.*.offset"', key="--parameters")
    with show_progress("calibrate") as update:
        done = calibrate_files(
            options.recordings,
            options.robot,
            options.parameters,
            options.output,
            options.cable_set,
            options.markers,
            options.capture,
            progress=update,
        )
    if not options.json:
        print_findings(done.findings, options.verbose)
        print_result(done.text)
    print_files(done.files, options.json)
    return GOOD
