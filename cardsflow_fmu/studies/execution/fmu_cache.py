"""Cache of FMUs for many runs: built once, unpacked once per process."""

from __future__ import annotations

import atexit
import hashlib
import shutil
import tempfile
from collections import OrderedDict
from dataclasses import replace
from pathlib import Path

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.models.by_role import model_class
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.open import PreparedFmu
from cardsflow_fmu.utils.archive import read_contents
from cardsflow_fmu.utils.temporary import TemporaryFolder

UNPACKED = "unpacked_"
"""Prefix of the folders with unpacked FMUs."""

MAX_CACHED = 4
"""Maximum number of unpacked sets of FMUs per process; different robots require different FMUs."""

_cache: OrderedDict[str, Path] = OrderedDict()


def prepared_fmus(base: Experiment, experiment: Experiment, shared: Path) -> dict[str, PreparedFmu]:
    """Return the FMUs for a run.

    Parameters are set when the FMUs are initialised. Runs that differ in other settings use
    separate FMUs.

    Args:
        base: The experiment without variations.
        experiment: The experiment of the run.
        shared: Folder with the FMUs of the base and for unpacked FMUs. If it does not exist, a
            temporary folder is used.
    """
    built = with_parameters_of(base, experiment)
    digest = _digest(built)
    if digest not in _cache or not _cache[digest].is_dir():
        _add(digest, _fmu_folder(built, shared, is_base=digest == _digest(base)))
    _cache.move_to_end(digest)
    return {
        name: PreparedFmu(
            _cache[digest] / f"{name}.fmu",
            _cache[digest] / name,
            _start_values(name, built, experiment),
        )
        for name in _names(experiment)
    }


def _names(experiment: Experiment) -> list[str]:
    """Return the names of the FMUs of a run, without external FMUs."""
    names = (experiment.model_of(role) for role in experiment.roles)
    return [name for name in names if name not in experiment.fmus]


def with_parameters_of(base: Experiment, experiment: Experiment) -> Experiment:
    """Return the experiment with the base's values for all parameters of its FMUs."""
    if experiment.hardware.use:  # an emulated robot has no FMU parameters
        return experiment
    controller, plant, robot = experiment.controller, experiment.plant, experiment.robot
    same_gains = len(base.controller.kp) == len(controller.kp)
    muscles = {muscle.name: muscle for muscle in base.robot.muscles}
    bounded = [
        replace(m, f_min=muscles[m.name].f_min, f_max=muscles[m.name].f_max)
        if m.name in muscles
        else m
        for m in robot.muscles
    ]
    if same_gains:
        known = base.controller
        controller = controller.copy_with(kp=known.kp, kd=known.kd, period=known.period)
    same_start = len(base.start.q) == len(experiment.start.q)
    return replace(
        experiment,
        robot=robot.with_muscles(bounded),
        controller=controller,
        plant=plant.copy_with(step=base.plant.step),
        start=base.start if same_start else experiment.start,
        run=experiment.run.copy_with(output=base.run.output),
    )


def _start_values(name: str, built: Experiment, experiment: Experiment) -> dict[str, float]:
    """Return the parameters in which a run differs from the defaults of its FMU."""
    model = model_class(name)
    pairs = zip(model.table(built), model.table(experiment), strict=True)
    return {
        new.name: new.start
        for old, new in pairs
        if new.causality == "parameter" and old.start != new.start
    }


def _digest(experiment: Experiment) -> str:
    """Return the hash of the resources of the FMUs and of the engine."""
    digest = hashlib.sha256(experiment.run.compute.encode())
    resources = experiment_resources(experiment, with_hardware=experiment.hardware.use)
    for name, source in sorted(resources.items()):
        content = read_contents(source)
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _fmu_folder(experiment: Experiment, shared: Path, *, is_base: bool) -> Path:
    """Return a folder of this process with the FMUs, into which instances unpack them once."""
    if shared.is_dir():
        folder = Path(tempfile.mkdtemp(dir=shared, prefix=UNPACKED))
    else:
        temporary = TemporaryFolder()
        atexit.register(temporary.remove)
        folder = temporary.path / "fmus"  # the temporary folder contains a lock file
        folder.mkdir()
    files = [shared / f"{name}.fmu" for name in _names(experiment)]
    if is_base and all(file.is_file() for file in files):
        for file in files:
            shutil.copy(file, folder)
    else:
        build(experiment, folder)
    return folder


def remove_unpacked(shared: Path) -> None:
    """Remove the unpacked FMUs of all processes, including killed ones."""
    for folder in shared.glob(f"{UNPACKED}*"):
        shutil.rmtree(folder, ignore_errors=True)


def _add(digest: str, folder: Path) -> None:
    _cache[digest] = folder
    while len(_cache) > MAX_CACHED:
        _, oldest = _cache.popitem(last=False)
        shutil.rmtree(oldest, ignore_errors=True)
