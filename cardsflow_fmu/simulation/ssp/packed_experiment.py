"""Experiment in the FMUs of an .ssp file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from addin_sdfusion.robot import CardsflowError, InputError, limits
from cardsflow_fmu.cosim.signals.roles import HARDWARE
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.utils.archive import (
    archive_bytes,
    open_archive,
    open_inner_archive,
    read_entry,
    unpack_archive,
)
from cardsflow_fmu.utils.temporary import temporary_folder

_RESOURCES = "resources/"
_PARTS = ("robot", "robots", "world")


def system_experiment(path: Path) -> bytes | None:
    """Return the content of experiment.zip, from the first FMU with an experiment.

    Damaged archives are ignored here; the reader of the .ssp reports them.

    Returns:
        The archive; None without an FMU of CARDSFlow.
    """
    for files in _packed_files_of_fmus(path, first="plant.fmu"):
        return archive_bytes(files)
    return None


def system_hardware(path: Path) -> HardwareSettings | None:
    """Return the hardware settings in the hardware FMU.

    Returns:
        The settings; None without a hardware FMU of CARDSFlow.
    """
    for files in _packed_files_of_fmus(path, first=f"{HARDWARE}.fmu"):
        with temporary_folder() as scratch:
            archive = scratch / "experiment.zip"
            archive.write_bytes(archive_bytes(files))
            try:
                if HARDWARE not in json.loads(files[EXPERIMENT_FILE]):
                    continue
                folder = unpack_archive(archive, scratch / "experiment", "archive", "an experiment")
                return Experiment.from_resources(folder).hardware
            except (CardsflowError, ValueError, TypeError):
                continue
    return None


def _packed_files_of_fmus(path: Path, first: str) -> Iterator[dict[str, bytes]]:
    """Yield the experiment files of FMUs; the FMU of the given name comes first."""
    try:
        with open_archive(path, ".ssp") as system:
            fmus = [entry for entry in system.infolist() if entry.filename.endswith(".fmu")]
            fmus.sort(key=lambda entry: (not entry.filename.endswith(first), entry.filename))
            for fmu in fmus:
                files = _packed_files(read_entry(system, fmu, limits.INNER_FMU))
                if files:
                    yield files
    except InputError:
        return


def _packed_files(fmu: bytes) -> dict[str, bytes]:
    """Return the experiment and robot files in an FMU; empty without an experiment."""
    with open_inner_archive(fmu) as archive:
        entries = {
            entry.filename.removeprefix(_RESOURCES): entry
            for entry in archive.infolist()
            if entry.filename.startswith(_RESOURCES) and _is_experiment_file(entry.filename)
        }
        if EXPERIMENT_FILE not in entries:
            return {}
        if sum(entry.file_size for entry in entries.values()) > limits.UNPACKED_IN_MEMORY:
            return {}
        return {
            name: read_entry(archive, entry, limits.UNPACKED_IN_MEMORY)
            for name, entry in entries.items()
        }


def _is_experiment_file(name: str) -> bool:
    parts = PurePosixPath(name).parts[1:]
    return parts == (EXPERIMENT_FILE,) or (len(parts) > 1 and parts[0] in _PARTS)
