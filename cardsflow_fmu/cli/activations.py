"""`cardsflow activations`: muscle forces and activations along a given motion."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.overwrite import NOT_OWN

from .common import (
    FAILED,
    GOOD,
    add_json,
    add_output,
    add_overwrite,
    add_robot,
    print_findings,
    use_one_thread,
)
from .parser import Commands
from .terminal.messages import print_note
from .terminal.progress import show_progress

if TYPE_CHECKING:
    from addin_sdfusion.robot.formats.read import Reading
    from cardsflow_fmu.results.analysis.redundancy.motion import GivenMotion
    from cardsflow_fmu.results.analysis.redundancy.static import Activations
    from cardsflow_fmu.utils.arrays import FloatArray

_TABLE = "results.csv"


def add_activations(commands: Commands) -> None:
    """Add `activations`."""
    parser = commands.add(
        "activations",
        _activations,
        "Estimate muscle activations of a recorded motion by static optimisation.",
        "cardsflow activations arm26.osim --motion reach.mot -o reach",
    )
    add_robot(parser)
    text = "joint positions over time: .mot, .sto, .csv, .npy, .npz or a ROS 2 recording (required)"
    parser.add_argument("--motion", type=Path, required=True, metavar="FILE", help=text)
    parser.add_argument(
        "--noise",
        type=float,
        metavar="X",
        help="standard deviation of the position noise, in rad or m; 0 interpolates the positions "
        "(default: estimated from the positions)",
    )
    text = "external loads of OpenSim (.xml), such as ground reaction forces (default: none)"
    parser.add_argument("--loads", type=Path, metavar="FILE", help=text)
    for option, row in (("--begin", "first"), ("--end", "last")):
        text = f"{row} time of the analysis, in s (default: the {row} row)"
        parser.add_argument(option, type=float, metavar="X", help=text)
    parser.add_argument(
        "--frames",
        type=int,
        metavar="N",
        help="number of equidistant times (default: the times of the rows; with --dynamics, every "
        "0.01 s)",
    )
    text = "include passive muscle forces (default: exclude them, like OpenSim)"
    parser.add_argument("--passive", action="store_true", help=text)
    parser.add_argument(
        "--dynamics",
        action="store_true",
        help="optimise the whole motion with activation dynamics, elastic tendons and passive "
        "forces (default: each time separately, by static optimisation)",
    )
    text = "exponent of the excitations in the cost, with --dynamics (default: 2)"
    parser.add_argument("--power", type=float, metavar="P", help=text)
    text = "torque of reserve actuators at a cost of 1, with --dynamics (default: 1)"
    parser.add_argument("--reserve", type=float, metavar="X", help=text)
    text = "write a replay of the motion as a self-contained HTML page (default: none)"
    parser.add_argument("--html", type=Path, metavar="FILE", help=text)
    text = "folder for activations.sto, forces.sto, results.csv and further tables"
    add_output(parser, text, default=Path("activations"), metavar="FOLDER")
    add_overwrite(parser)
    add_json(parser)


def _activations(options: argparse.Namespace) -> int:
    use_one_thread()
    import numpy as np

    from addin_sdfusion.robot.files import write_files
    from addin_sdfusion.robot.formats.read import read
    from cardsflow_fmu.results.analysis.redundancy.columns import motion_columns
    from cardsflow_fmu.results.analysis.redundancy.output import (
        activation_files,
        activation_summary,
        describe_activations,
    )
    from cardsflow_fmu.utils.csv_table import csv_text
    from cardsflow_fmu.utils.overwrite import output_file

    _require_dynamics(options)
    if options.html is not None:
        output_file(options.html, [".html"], overwrite=options.overwrite)
    reading = read(options.robot, options.cable_set)
    with show_progress("activations"):
        recorded, activations = _compute(options, reading)
        columns = motion_columns(recorded, activations)
    contents, summary = activation_files(activations), activation_summary(activations)
    contents[_TABLE] = csv_text(list(columns), np.stack(list(columns.values()), axis=1))
    if not options.overwrite:
        _require_own_files(options.output, contents)
    if recorded.locked:
        names = ", ".join(f"{name} = {q:g}" for name, q in recorded.locked.items())
        print_note(f"the motion does not contain some coordinates, which are locked: {names}")
    print_findings(reading.findings)
    if not options.json:
        print(describe_activations(summary))
    files = write_files(options.output, contents)
    if options.html is not None:
        files.append(_write_replay(options, reading, recorded, columns))
    if options.json:
        named = {"files": {file.name: str(file) for file in files}}
        print(json_text({**summary, **named}, indent=1))
    else:
        print(f"files  {options.output}: {', '.join(file.name for file in files)}")
    return FAILED if summary["infeasible"] else GOOD


def _compute(options: argparse.Namespace, reading: Reading) -> tuple[GivenMotion, Activations]:
    from cardsflow_fmu.results.analysis.redundancy.loads import add_external_loads
    from cardsflow_fmu.results.analysis.redundancy.motion import read_given_motion
    from cardsflow_fmu.results.analysis.redundancy.over_time import FRAME_STEP, optimise_activations
    from cardsflow_fmu.results.analysis.redundancy.static import static_optimisation

    recorded = read_given_motion(
        reading.require(),
        options.motion,
        options.noise,
        begin=options.begin,
        end=options.end,
        frames=options.frames,
        step=FRAME_STEP if options.dynamics else 0.0,
    )
    if options.loads is not None:
        recorded = add_external_loads(recorded, options.loads)
    robot, motion = recorded.robot, recorded.motion
    if not options.dynamics:
        return recorded, static_optimisation(robot, motion, passive=options.passive)
    settings = {"reserve": options.reserve, "power": options.power}
    chosen = {key: value for key, value in settings.items() if value is not None}
    return recorded, optimise_activations(robot, motion, **chosen)


def _write_replay(
    options: argparse.Namespace,
    reading: Reading,
    recorded: GivenMotion,
    columns: Mapping[str, FloatArray],
) -> Path:
    import numpy as np

    from cardsflow_fmu.results.run_data import RunData
    from cardsflow_fmu.results.viewer.scene.act import Act
    from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
    from cardsflow_fmu.results.viewer.scene.motion import motion_of, shown_signals
    from cardsflow_fmu.results.viewer.scene.stage import Stage
    from cardsflow_fmu.results.viewer.view import write_page

    rows = np.stack(list(columns.values()), axis=1)
    data, robot = RunData(tuple(columns), rows, {}, {}), recorded.robot
    meshes = link_meshes(robot, reading.files[0].parent)
    stage = Stage(robot, motion_of(robot, data), meshes)
    act = Act(stage, robot.name, (), shown_signals(data))
    return write_page([act], options.html, overwrite=options.overwrite)


def _require_dynamics(options: argparse.Namespace) -> None:
    """Check that options are only used with the method that they belong to."""
    for key in () if options.dynamics else ("power", "reserve"):
        if getattr(options, key) is not None:
            raise InputError("requires --dynamics", key=f"--{key}")
    if options.dynamics and options.passive:
        problem = "is for static optimisation; --dynamics includes passive forces"
        raise InputError(problem, key="--passive")


def _require_own_files(folder: Path, contents: Mapping[str, str]) -> None:
    """Check that existing files were written by `activations`."""
    is_own = (folder / "activations.sto").is_file()
    for name, text in contents.items():
        file, title = folder / name, text.partition("\n")[0]
        with contextlib.suppress(FileNotFoundError, NotADirectoryError), file.open("rb") as stream:
            first_line = stream.readline(100).strip()
            if not (is_own if name == _TABLE else first_line == title.encode()):
                raise InputError(NOT_OWN, file=file)
