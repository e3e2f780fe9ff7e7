"""The experiment that travels in the FMUs of an .ssp: whose results those of its runs are."""

from __future__ import annotations

import io
import tempfile
import zipfile
from pathlib import Path, PurePosixPath

from .archive import write_archive
from .experiment_resources import EXPERIMENT_FILE

_RESOURCES = "resources/"
_PARTS = ("robot", "robots", "world")
_MOST_BYTES = 2**28


def system_experiment(path: Path) -> bytes | None:
    """The contents of experiment.zip, from the first FMU that carries an experiment.

    What is wrong with the archive is for others to say: nothing is known of its robot then.

    Args:
        path: The .ssp.

    Returns:
        The archive; None where no FMU of ours is in it.
    """
    try:
        with zipfile.ZipFile(path) as system:
            for entry in sorted(system.infolist(), key=_plants_first):
                if entry.filename.endswith(".fmu") and entry.file_size <= _MOST_BYTES:
                    files = _carried(system.read(entry))
                    if files:
                        return _archive(files)
    except (OSError, ValueError, zipfile.BadZipFile, RuntimeError, NotImplementedError):
        return None
    return None


def _plants_first(entry: zipfile.ZipInfo) -> tuple[bool, str]:
    return not entry.filename.endswith("plant.fmu"), entry.filename


def _carried(fmu: bytes) -> dict[str, bytes]:
    """The experiment and its robot's files in an FMU; nothing where it has none."""
    with zipfile.ZipFile(io.BytesIO(fmu)) as archive:
        entries = {
            entry.filename.removeprefix(_RESOURCES): entry
            for entry in archive.infolist()
            if entry.filename.startswith(_RESOURCES) and _is_of_experiment(entry.filename)
        }
        if EXPERIMENT_FILE not in entries:
            return {}
        if sum(entry.file_size for entry in entries.values()) > _MOST_BYTES:
            return {}
        return {name: archive.read(entry) for name, entry in entries.items()}


def _is_of_experiment(name: str) -> bool:
    parts = PurePosixPath(name).parts[1:]
    return parts == (EXPERIMENT_FILE,) or (len(parts) > 1 and parts[0] in _PARTS)


def _archive(files: dict[str, bytes]) -> bytes:
    with tempfile.TemporaryDirectory() as aside:
        made = Path(aside) / "experiment.zip"
        write_archive(made, files)
        return made.read_bytes()
