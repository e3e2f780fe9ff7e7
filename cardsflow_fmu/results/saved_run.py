"""Reader of results folders: results, experiment and robot."""

from __future__ import annotations

import contextlib
import shlex
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import is_folder
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.packed_files import robot_folder, visual_meshes
from cardsflow_fmu.experiment.reader import EXPERIMENT_TOML
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.utils.archive import archive_bytes, read_contents, unpack_archive
from cardsflow_fmu.utils.csv_table import read_csv, require_table
from cardsflow_fmu.utils.temporary import TemporaryFolder

from .files import EXPERIMENT, NPY, NPY_SOLVE_TIMES, SOLVE_TIMES, SUMMARY, TABLE, UNITS
from .journal import STARTED
from .metadata import read_summary, read_units
from .row_store import read_npy
from .run_data import ExperimentRunData, RunData
from .summary import Speed, summarize

_TABLES = (TABLE, NPY)


def experiment_archive(experiment: Experiment) -> bytes:
    """Return the content of experiment.zip.

    Raises:
        InputError: A file of the robot cannot be read, or may not be packed.
    """
    files, roots = experiment_resources(experiment), experiment.roots
    if experiment.parts:
        for part in experiment.parts:
            folder = robot_folder(f"robots/{part.name}", part.files)
            files |= visual_meshes(folder, part.robot, part.folder, roots)
    else:
        folder = robot_folder("robot", experiment.robot_files)
        files |= visual_meshes(folder, experiment.robot, experiment.folder, roots)
    return archive_bytes({name: read_contents(source) for name, source in files.items()})


def is_run(path: Path) -> bool:
    """Return whether a path is a results folder or the table in it."""
    return any((_folder(path) / name).is_file() for name in _TABLES)


def require_not_experiment(path: Path) -> None:
    """Check that a path without results is not an experiment, or its missing results folder.

    Raises:
        InputError: It is. The message names the results of the experiment, or the command to run.
    """
    folder = path if is_folder(path) else path.parent
    file = path if path.suffix == ".toml" else folder / EXPERIMENT_TOML
    if not file.is_file() or (path.is_file() and path != file):
        return
    if is_run(folder / "results"):
        raise InputError(f"has no results of a run; specify {folder / 'results'}", file=path)
    command = f"cardsflow run {shlex.quote(str(file))}"
    raise InputError(f"has no results of a run; run the experiment first: {command}", file=path)


@contextlib.contextmanager
def opened_run(path: str | Path) -> Iterator[ExperimentRunData]:
    """Provide the result of a run with its experiment. Robot files are deleted at the end.

    Args:
        path: The results folder, or the table in it.
    """
    result = load_run(path)
    try:
        yield result
    finally:
        result.release()


@contextlib.contextmanager
def open_results(path: str | Path) -> Iterator[RunData]:
    """Provide a result, with its experiment if the results folder contains it."""
    if not (_folder(Path(path)) / EXPERIMENT).is_file() or not is_run(Path(path)):
        yield read_results(Path(path))
        return
    with opened_run(path) as result:
        yield result


def load_run(path: str | Path) -> ExperimentRunData:
    """Read the result of a run with its experiment.

    Robot files are deleted together with the experiment of the result.

    Raises:
        InputError: A file is missing or damaged.
    """
    folder = _folder(Path(path))
    result = read_results(folder)
    archive = folder / EXPERIMENT
    if not archive.is_file():
        problem = f"has no {EXPERIMENT}, which contains the robot; run the experiment again"
        raise InputError(problem, file=folder)
    scratch = TemporaryFolder()
    try:
        unpack_archive(archive, scratch.path, "archive of an experiment", "an experiment")
        loaded = ExperimentRunData(
            **vars(result), experiment=Experiment.from_resources(scratch.path)
        )
        _require_same_robot(loaded, archive)
    except BaseException:
        scratch.remove()
        raise
    if loaded.summary.get("error") == str(STARTED) and len(loaded.rows):
        loaded.summary |= _recomputed_summary(loaded)
    loaded.release = weakref.finalize(loaded.experiment, scratch.remove)
    return loaded


def _require_same_robot(result: ExperimentRunData, archive: Path) -> None:
    expected, robot = result.summary.get("robot"), result.experiment.robot.name
    if expected is not None and expected != robot:
        problem = f"is of robot {robot!r}, but the results are of {expected!r}"
        raise InputError(problem, file=archive)


def _recomputed_summary(result: ExperimentRunData) -> dict[str, Any]:
    """Compute tracking errors, forces and infeasible ticks for the summary of a killed run."""
    experiment, rows = result.experiment, len(result.rows)
    period = round(experiment.controller.period / experiment.run.step)
    ticks = np.arange(0, rows, period)
    recording = Recording(result.names, result.rows, result.units, ticks, np.empty(0), STARTED)
    summary = summarize(experiment, recording, Speed(0.0, 0.0))
    counts = ("infeasible_ticks", "not_converged_ticks", "fallback_ticks", "ticks")
    recomputed = ("tracking", "forces", *counts, "slack", "contact_friction", "warnings")
    return {key: summary[key] for key in recomputed if key in summary}


def read_results(path: Path) -> RunData:
    """Read table, units and summary of a run."""
    if path.suffix == ".toml":
        require_not_experiment(path)
    if path.name not in _TABLES and (path.suffix == ".csv" or path.is_file()):
        return _read_table(path)
    if not is_run(path):
        require_not_experiment(path)
        raise InputError("has no results of a run", file=path)
    folder = _folder(path)
    units, summary = read_units(folder / UNITS), read_summary(folder / SUMMARY)
    complete = summary.get("status") != "incomplete"
    file_name = next((name for name in _TABLES if (folder / name).is_file()), TABLE)
    table = folder / file_name
    if file_name == NPY:
        names, rows = tuple(units), read_npy(table, len(units))
        require_table(names, rows, table)
    else:
        names, rows = read_csv(table, complete=complete)
    if names[:1] != ("time",):
        raise InputError("its first column must be 'time'", file=table)
    if not complete and len(rows):
        summary["duration"] = float(rows[-1, 0])  # unknown for a killed run
    times = np.empty((0, 2))
    if (folder / SOLVE_TIMES).is_file():
        names_of_times, times = read_csv(folder / SOLVE_TIMES, complete=complete)
        if len(names_of_times) != 2:
            raise InputError(
                "is not a table of computation times of ticks", file=folder / SOLVE_TIMES
            )
    elif (folder / NPY_SOLVE_TIMES).is_file():
        times = read_npy(folder / NPY_SOLVE_TIMES, 2)
    files = (table, folder / UNITS, folder / SUMMARY)
    return RunData(names, rows, units, summary, {f.name: f for f in files}, times)


def _read_table(file: Path) -> RunData:
    """Read a table without summary and units."""
    names, rows = read_csv(file)
    return RunData(names, rows, {}, {}, {file.name: file})


def _folder(path: Path) -> Path:
    return path.parent if path.name in _TABLES else path
