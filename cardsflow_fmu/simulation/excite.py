"""Experiments whose motion identifies a robot's numbers, ready to run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import CardsflowError, Finding, InputError, Robot
from addin_sdfusion.robot.files import write_files
from addin_sdfusion.robot.model.trajectory import Trajectory, TrajectoryPoint
from cardsflow_fmu.cosim.signals.port import coordinate_signals
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.template import Beginning, experiment_text
from cardsflow_fmu.results.analysis.excitation.design import (
    DURATION,
    NOISE,
    READ,
    SPEED,
    Excitation,
    excitations,
)
from cardsflow_fmu.results.report.calibration import unidentified
from cardsflow_fmu.utils.csv_table import csv_text
from cardsflow_fmu.utils.folder_lock import new_folder
from sim_dart.calibration.identifiability import identifiable

from .starter import path_from, read_movable
from .trials import Search, Trial

MOTION, REPORT = "motion.csv", "excitation.txt"

FREE = ("muscles.*.offset", "muscles.*.via_points", "links.*.inertia", "joints.*.damping")
"""What is to be found when nothing is asked for."""

_SIZES = 6
_FOLLOWED = 0.05
"""Most that a trial may be off, in [rad] or [m]."""


@dataclass(frozen=True)
class Excited:
    """What has been written.

    Attributes:
        files: The experiment, its motion and the report.
        text: The report.
        findings: What is doubtful in the robot's files.
    """

    files: list[Path]
    text: str
    findings: tuple[Finding, ...]


def excite(
    robot: str | Path,
    free: Sequence[str],
    folder: Path,
    cable_set: str | None = None,
    duration: float = DURATION,
    speed: float = SPEED,
) -> Excited:
    """Design a motion from which a calibration identifies what is free, as an experiment.

    Args:
        robot: A robot's file or its folder.
        free: What a calibration is to find; see `sim_dart.calibration.parameters.GROUPS`. `FREE`
            when empty.
        folder: For experiment.toml, motion.csv and the report; new, or empty.
        cable_set: The cable set; the file's own when None.
        duration: Of the motion, in [s].
        speed: Largest, in [rad/s].

    Raises:
        InputError: The robot cannot be read or moved, or has nothing of what is asked for.
        RobotError: It cannot be used.
        CardsflowError: No motion was followed in a trial. Nothing is written.
    """
    with new_folder(folder, "excitation"):
        found, findings = read_movable(robot, cable_set)
        search = Search(found, Path(robot), cable_set)
        first, _ = search.best()
        if first.locked:
            name, (_, why) = next(iter(first.locked.items()))
            raise InputError(
                f"robot {found.name!r} cannot move {name}: {why}; what does not move is not "
                "identifiable: make it a fixed joint of the robot",
                file=robot,
            )
        start = np.array(first.motion.points[0].q)
        designed = excitations(_bounded(found, first), start, free or FREE, duration, speed)
        design, beginning, trial = _followed(search, first, islice(designed, _SIZES))
        text = described(design, trial, _next(folder, robot, free or FREE))
        written = replace(beginning, file=MOTION)
        path = path_from(folder, Path(robot))
        contents = {
            EXPERIMENT_TOML: experiment_text(found, path, written, cable_set),
            MOTION: _table(found, design),
            REPORT: text + "\n",
        }
        return Excited(write_files(folder, contents), text, findings)


def _bounded(robot: Robot, beginning: Beginning) -> Robot:
    """The robot with the force bounds that its files lack."""
    muscles = [replace(m, f_max=beginning.f_max.get(m.name, m.f_max)) for m in robot.muscles]
    return robot.with_muscles(muscles) if beginning.f_max else robot


def _followed(
    search: Search, first: Beginning, designed: Iterable[Excitation]
) -> tuple[Excitation, Beginning, Trial | None]:
    """The largest of some motions that is followed in a trial.

    Raises:
        CardsflowError: None is.
    """
    tried = ""
    for design in designed:
        motion = _trajectory(design)
        what = "a motion that identifies its numbers, for `cardsflow calibrate`"
        beginning = replace(first, motion=motion, what=what, remarks=())
        trial = search.tried(beginning)
        if trial is None:
            note = "not tried: it has something that the native models lack"
            return design, replace(beginning, remarks=(note,)), None
        if trial.complete and not trial.infeasible and trial.error <= _FOLLOWED:
            return design, beginning, trial
        tried = (
            f"errors up to {trial.error:.3g} of {trial.worst}, {trial.infeasible} infeasible ticks"
        )
    raise CardsflowError(
        f"robot {search.robot.name!r} follows no such motion in a trial: {tried}; ask for a slower "
        "one by --speed"
    )


def _trajectory(design: Excitation) -> Trajectory:
    m = design.motion
    rows = zip(m.times.tolist(), m.q.tolist(), m.qd.tolist(), m.qdd.tolist(), strict=True)
    points = tuple(TrajectoryPoint(t, tuple(q), tuple(v), tuple(a)) for t, q, v, a in rows)
    return Trajectory("excitation", "quintic", points, READ)


def _table(robot: Robot, design: Excitation) -> str:
    rows = np.column_stack([design.motion.times, design.motion.q])
    return csv_text(["time", *coordinate_signals("q", robot)], rows)


def _next(folder: Path, robot: str | Path, free: Sequence[str]) -> list[str]:
    """How it goes on."""
    patterns = ", ".join(free)
    return [
        f"record      cardsflow run {folder} --hardware udp://HOST:PORT",
        f"calibrate   cardsflow calibrate {folder / 'results'} --robot {robot} "
        f'--parameters "{patterns}" -o calibrated',
    ]


def described(design: Excitation, trial: Trial | None, next_: Sequence[str]) -> str:
    """The report on a motion.

    Args:
        design: It.
        trial: How it was followed in a simulation, where there was one.
        next_: Lines on how it goes on.
    """
    seen, m = identifiable(design), design.motion
    forces = design.forces
    lines = [
        f"{len(seen)} numbers; a recording of the motion identifies {seen.sum()} of them",
        f"motion      {m.times[-1]:g} s, up to {np.abs(m.qd).max():.3g} rad/s or m/s, forces "
        f"{forces.min():.4g} to {forces.max():.4g} N",
        f"readings    every {1e3 * READ:g} ms, with {1e3 * NOISE:g} mrad or mm of noise, which "
        "deviations go with",
    ]
    if trial is not None:
        lines.append(f"trial       errors up to {trial.error:.2g} rad or m")
    lines += [*next_, "", "predicted                                              sd     prior"]
    for one, sd, is_seen in zip(design.parameters, design.sd, seen, strict=True):
        mark = "" if is_seen else "  not identifiable: held by its prior"
        lines.append(f"{one.name:47s} {sd:9.2g} {one.sd:9.2g} {one.unit}{mark}")
    lines += unidentified(design)
    return "\n".join([*lines, *(f"WARNING {note}" for note in design.notes)])
