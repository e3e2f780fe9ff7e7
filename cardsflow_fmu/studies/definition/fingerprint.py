"""Hash of the common part of all runs of a study."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.utils.archive import read_contents
from cardsflow_fmu.version import __version__

from .study import Study

_SUFFIXES = (".xml", ".sdf", ".traj", ".config")


def fingerprint(study: Study, experiment: str) -> str:
    """Return the hash of a study without its variations."""
    content = {
        "experiment": experiment,
        "compute": study.compute,
        "metrics": study.metrics,
        "box": None if study.box is None else study.box.data(),
        "version": __version__,
    }
    return hashlib.sha256(json_text(content, sort_keys=True).encode()).hexdigest()


def experiment_digest(experiment: Experiment) -> str:
    """Return the hash of an experiment with all files that it or its variations can use.

    The hash does not include paths of files, so that it is the same on every computer.

    Args:
        experiment: The experiment without variations.
    """
    digest = hashlib.sha256()
    resources = experiment_resources(experiment, with_hardware=True)
    packed = [(name, read_contents(source)) for name, source in sorted(resources.items())]
    for name, content in (*packed, *_files(experiment)):
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _files(experiment: Experiment) -> Iterator[tuple[str, bytes]]:
    """Yield external FMUs and the other files in the robot's folder, such as trajectories."""
    for role, fmu in sorted(experiment.fmus.items()):
        yield f"fmus/{role}", read_contents(Path(fmu.file))
        yield f"fmus/{role}.txt", repr(replace(fmu, file=Path())).encode()
    for file in sorted(experiment.robot_path.parent.iterdir()):
        if file.suffix in _SUFFIXES and file.is_file():
            yield f"beside/{file.name}", read_contents(file)
