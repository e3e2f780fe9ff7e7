"""Experiments with a motion that identifies parameters of a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import CardsflowError, InputError, Robot
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu.cosim.signals.port import coordinate_signals
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.template import ExperimentDraft, experiment_text
from cardsflow_fmu.results.analysis.excitation.design import (
    DURATION,
    NOISE,
    READ,
    SPEED,
    Excitation,
    excitations,
)
from cardsflow_fmu.results.report.calibration import WrittenReport, unidentifiable_lines
from cardsflow_fmu.utils.csv_table import csv_text
from cardsflow_fmu.utils.folder_lock import create_new_folder
from sim_dart.calibration.identifiability import identifiable

from .draft_search import DraftSearch, TestRun
from .starter import path_from, read_movable

MOTION, REPORT = "motion.csv", "excitation.txt"

DEFAULT_PARAMETERS = (
    "muscles.*.offset",
    "muscles.*.via_points",
    "links.*.inertia",
    "joints.*.damping",
)
"""Patterns of the parameters that are identified by default."""

_DESIGN_SHARE = 0.6
"""Expected share of the design in the computation time."""

_MAX_MOTIONS = 6
_MAX_ERROR = 0.05
"""Maximum tracking error of a test run, in [rad] or [m]."""


def excite(
    robot: str | Path,
    parameters: Sequence[str],
    folder: Path,
    cable_set: str | None = None,
    duration: float = DURATION,
    speed: float = SPEED,
    progress: Callable[[int, int], None] | None = None,
) -> WrittenReport:
    """Write an experiment with a motion from which a calibration identifies parameters.

    Args:
        robot: Robot file or its folder.
        parameters: Patterns of the parameters; see `sim_dart.calibration.parameters.GROUPS`. If
            it is empty, `DEFAULT_PARAMETERS` is used.
        folder: New or empty folder of experiment.toml, motion.csv and the report.
        cable_set: Name of the cable set (default: as in the robot file).
        duration: Duration of the motion, in [s].
        speed: Maximum joint speed, in [rad/s].
        progress: Called with the completed work and its total, first with 0, and with the total
            after the test runs.

    Raises:
        InputError: The robot cannot be read or moved, or has none of the parameters.
        RobotError: The robot is invalid.
        CardsflowError: Every test run failed. No file is written.
    """
    total = 1

    def report(done: int, of_design: int) -> None:
        nonlocal total
        total = round(of_design / _DESIGN_SHARE)
        if progress is not None:
            progress(done, total)

    with create_new_folder(folder, "excitation"):
        movable, findings = read_movable(robot, cable_set, folder)
        search = DraftSearch(movable, Path(robot), cable_set)
        first, _ = search.find_best()
        if first.locked:
            name, (_, why) = next(iter(first.locked.items()))
            raise InputError(
                f"robot {movable.name!r} cannot move {name} ({why}); parameters of a joint without "
                "motion are unidentifiable; make it a fixed joint",
                file=robot,
            )
        start = np.array(first.motion.points[0].q)
        designed = excitations(
            _with_force_limits(movable, first),
            start,
            parameters or DEFAULT_PARAMETERS,
            duration,
            speed,
            progress=report,
        )
        design, draft, test_run = _largest_trackable_motion(
            search, first, islice(designed, _MAX_MOTIONS)
        )
        if progress is not None:
            progress(total, total)
        text = describe_excitation(
            design, test_run, _next_commands(folder, robot, parameters or DEFAULT_PARAMETERS)
        )
        written = replace(draft, file=MOTION)
        path = path_from(folder, Path(robot))
        contents = {
            EXPERIMENT_TOML: experiment_text(movable, path, written, cable_set),
            MOTION: _table(movable, design),
            REPORT: text + "\n",
        }
        return WrittenReport(write_files(folder, contents), text, findings)


def _with_force_limits(robot: Robot, draft: ExperimentDraft) -> Robot:
    """Return the robot with the force limits that its files do not specify."""
    muscles = [replace(m, f_max=draft.f_max.get(m.name, m.f_max)) for m in robot.muscles]
    return robot.with_muscles(muscles) if draft.f_max else robot


def _largest_trackable_motion(
    search: DraftSearch, first: ExperimentDraft, designed: Iterable[Excitation]
) -> tuple[Excitation, ExperimentDraft, TestRun | None]:
    """Return the first motion whose test run passes; the motions are sorted by size.

    Raises:
        CardsflowError: Every test run failed.
    """
    failure = ""
    for design in designed:
        motion = _trajectory(design)
        summary = "a motion that identifies parameters, for `cardsflow calibrate`"
        draft = replace(first, motion=motion, summary=summary, notes=())
        test_run = search.run_test(draft)
        if test_run is None:
            note = "no test run: the native models do not support this robot"
            return design, replace(draft, notes=(note,)), None
        if test_run.complete and not test_run.infeasible and test_run.error <= _MAX_ERROR:
            return design, draft, test_run
        failure = (
            f"tracking error up to {test_run.error:.3g} {test_run.unit} at {test_run.worst}, "
            f"{test_run.infeasible} infeasible ticks"
        )
    raise CardsflowError(
        f"robot {search.robot.name!r}: every test run failed: {failure}; use a lower --speed"
    )


def _trajectory(design: Excitation) -> Trajectory:
    m = design.motion
    rows = zip(m.times.tolist(), m.q.tolist(), m.qd.tolist(), m.qdd.tolist(), strict=True)
    points = tuple(TrajectoryPoint(t, tuple(q), tuple(v), tuple(a)) for t, q, v, a in rows)
    return Trajectory("excitation", "quintic", points, READ)


def _table(robot: Robot, design: Excitation) -> str:
    rows = np.column_stack([design.motion.times, design.motion.q])
    return csv_text(["time", *coordinate_signals("q", robot)], rows)


def _next_commands(folder: Path, robot: str | Path, parameters: Sequence[str]) -> list[str]:
    patterns = ", ".join(parameters)
    return [
        f"record      cardsflow run {folder} --hardware udp://HOST:PORT",
        f"calibrate   cardsflow calibrate {folder / 'results'} --robot {robot} "
        f'--parameters "{patterns}" -o calibrated',
    ]


def describe_excitation(design: Excitation, test_run: TestRun | None, next_: Sequence[str]) -> str:
    """Return the report on a motion.

    Args:
        test_run: Result of its test run; None without a test run.
        next_: Lines with the commands of the next steps.
    """
    is_known, m = identifiable(design), design.motion
    forces = design.forces
    lines = [
        f"{len(is_known)} parameters; a recording of the motion identifies {is_known.sum()} of "
        "them",
        f"motion      {m.times[-1]:g} s, up to {np.abs(m.qd).max():.3g} rad/s or m/s, forces "
        f"{forces.min():.4g} to {forces.max():.4g} N",
        f"sampling    every {1e3 * READ:g} ms, noise {1e3 * NOISE:g} mrad or mm; the predicted "
        "standard deviations are proportional to the noise",
    ]
    if test_run is not None:
        lines.append(f"test run    tracking error up to {test_run.error:.2g} {test_run.unit}")
    lines += [*next_, "", "predicted                                              sd     prior"]
    for one, sd, is_identified in zip(design.parameters, design.sd, is_known, strict=True):
        mark = "" if is_identified else "  unidentifiable: determined by its prior"
        lines.append(f"{one.name:47s} {sd:9.2g} {one.sd:9.2g} {one.unit}{mark}")
    lines += unidentifiable_lines(design)
    return "\n".join([*lines, *(f"WARNING {note}" for note in design.notes)])
