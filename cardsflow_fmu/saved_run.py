"""The run that a folder holds: its results, and the experiment and robot that gave them."""

from __future__ import annotations

import contextlib
import json
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError

from .archive import unpack_archive, write_archive
from .experiment import Experiment
from .mesh_files import mesh_files, own_name
from .results import SUMMARY, TABLE, UNITS, Result, SystemResult

EXPERIMENT = "experiment.zip"
"""The experiment as its FMUs carry it, with the robot's files, and its meshes besides."""


def experiment_archive(experiment: Experiment) -> bytes:
    """The contents of experiment.zip.

    Args:
        experiment: What is run.

    Raises:
        InputError: A file of the robot cannot be read.
    """
    files = experiment.resources()
    meshes = mesh_files(experiment.robot, experiment.robot_path.parent)
    files |= {f"robot/{own_name(uri)}": file for uri, file in meshes.items()}
    with tempfile.TemporaryDirectory() as aside:
        archive = Path(aside) / EXPERIMENT
        write_archive(archive, {name: _bytes(source) for name, source in files.items()})
        return archive.read_bytes()


def is_run(path: Path) -> bool:
    """Whether a path is a folder that a run has written, or the table in it."""
    return (_folder(path) / TABLE).is_file()


@contextlib.contextmanager
def opened_run(path: str | Path) -> Iterator[Result]:
    """The result that a run has written, with its experiment; the robot's files are there inside.

    Args:
        path: The folder of the run, or the table in it.

    Raises:
        InputError: Something is missing or damaged.
    """
    folder = _folder(Path(path))
    result = read_results(folder)
    archive = folder / EXPERIMENT
    if not archive.is_file():
        what = f"holds no {EXPERIMENT}, so its robot is not known; run the experiment again"
        raise InputError(what, file=folder)
    with tempfile.TemporaryDirectory() as aside:
        unpack_archive(archive, Path(aside), "archive of an experiment", "an experiment")
        yield Result(
            result.names,
            result.rows,
            result.units,
            result.summary,
            result.files,
            experiment=Experiment.from_resources(Path(aside)),
        )


def read_results(folder: Path) -> SystemResult:
    """The table, units and summary that a run has written.

    Args:
        folder: The folder of the run.

    Raises:
        InputError: A file is missing or damaged.
    """
    table = folder / TABLE
    try:
        with table.open(encoding="utf-8") as stream:
            names = tuple(stream.readline().rstrip("\n").split(","))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # about a table without rows
                rows = np.loadtxt(stream, delimiter=",", ndmin=2).reshape(-1, len(names))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=table) from None
    except ValueError as error:
        raise InputError(f"is no table of results: {error}", file=table) from None
    units, summary = _json(folder / UNITS), _json(folder / SUMMARY)
    files = {file.name: file for file in (table, folder / UNITS, folder / SUMMARY)}
    return SystemResult(names, rows, units, summary, files)


def _folder(path: Path) -> Path:
    return path.parent if path.name == TABLE else path


def _json(file: Path) -> dict[str, Any]:
    try:
        data = json.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
    except ValueError as error:
        raise InputError(f"is no JSON: {error}", file=file) from None
    if not isinstance(data, dict):
        raise InputError("is not what a run writes", file=file)
    return data


def _bytes(source: bytes | Path) -> bytes:
    if isinstance(source, bytes):
        return source
    try:
        return source.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=source) from None
