"""`cardsflow excite` and `calibrate`: a robot's numbers from recordings."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError

from .common import (
    GOOD,
    ROBOT_FILE,
    Commands,
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

if TYPE_CHECKING:
    pass

_FREE = (
    "muscles.*.offset, .via_points, .stiffness, .friction; links.*.inertia; "
    "joints.*.damping, .friction; motors.*.gain, .armature; delays.tensions, delays.lengths"
)


def add_excite(commands: Commands) -> None:
    """Add `excite`."""
    parser = commands.add(
        "excite",
        _excite,
        "Design a motion that identifies a robot's numbers, as an experiment to run and record; "
        "say which no recording of it will tell.",
        'cardsflow excite robot --free "muscles.*.offset, muscles.*.via_points" -o exciting',
    )
    add_robot(parser)
    add_words(
        parser,
        "--free",
        "PATTERN",
        f"what `cardsflow calibrate` is to find: {_FREE}; when left out, offsets, via points, "
        "inertias and damping",
    )
    parser.add_argument("--duration", type=float, default=20.0, metavar="S", help="in s; 20")
    parser.add_argument(
        "--speed", type=float, default=1.5, metavar="V", help="largest, in rad/s; 1.5"
    )
    add_output(parser, "folder for the experiment; new, or empty", required=True)
    add_json(parser, "the files")
    add_verbose(parser)


def add_calibrate(commands: Commands) -> None:
    """Add `calibrate`."""
    parser = commands.add(
        "calibrate",
        _calibrate,
        "Correct a robot's numbers by recordings; say which are not identifiable.",
        "cardsflow calibrate results/hardware.rec --robot robot "
        '--free "muscles.*.offset, joints.*.damping" -o calibrated',
    )
    recorded = "a hardware.rec, a run's folder, or a table with time, q.*, l.*, f.*"
    parser.add_argument(
        "recordings", type=Path, nargs="+", metavar="RECORDING", help=f"{recorded}; of several the "
        "last is kept out, of one its end"
    )  # fmt: skip
    parser.add_argument("--robot", type=Path, required=True, help=ROBOT_FILE)
    add_cable_set(parser)
    add_words(parser, "--free", "PATTERN", f"{_FREE}; markers.*.position")
    parser.add_argument(
        "--markers",
        type=Path,
        metavar="FILE",
        help="markers of motion capture on the robot, a table for each, in TOML: link, position",
    )
    parser.add_argument(
        "--capture",
        type=Path,
        action="append",
        default=[],
        metavar="CSV",
        help="where they were seen: time, MARKER.x, .y, .z, in m in the robot's world; once for "
        "each recording that has no such columns itself",
    )
    add_output(parser, "folder for the new robot and the report; new, or empty", required=True)
    add_json(parser, "the files")
    add_verbose(parser)


def _patterns(words: list[str]) -> list[str]:
    return [word.strip() for word in words]


def _excite(options: argparse.Namespace) -> int:
    from cardsflow_fmu.simulation.excite import excite

    done = excite(
        options.robot,
        _patterns(options.free),
        options.output,
        options.cable_set,
        options.duration,
        options.speed,
    )
    if not options.json:
        print_findings(done.findings, options.verbose)
        print_result(done.text)
    print_files(done.files, options.json)
    return GOOD


def _calibrate(options: argparse.Namespace) -> int:
    from cardsflow_fmu.results.report.calibration import calibrate_files

    free = _patterns(options.free)
    if not free:
        raise InputError('missing: what may change, such as "muscles.*.offset"', key="--free")
    done = calibrate_files(
        options.recordings,
        options.robot,
        free,
        options.output,
        options.cable_set,
        options.markers,
        options.capture,
    )
    if not options.json:
        print_findings(done.findings, options.verbose)
        print_result(done.text)
    print_files(done.files, options.json)
    return GOOD
