"""FMUs of many runs: built once, unpacked once a process, with parameters set at the start."""

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
"""Prefix of the folders that FMUs are unpacked into."""

MAX_KEPT = 4
"""Number of sets of FMUs that a process keeps unpacked: different robots need different FMUs."""

_kept: OrderedDict[str, Path] = OrderedDict()


def prepared_fmus(base: Experiment, experiment: Experiment, shared: Path) -> dict[str, PreparedFmu]:
    """Return the FMUs for a run.

    Parameters are set at the start; a run that differs in anything else has FMUs of its own.

    Args:
        base: The experiment without variations.
        experiment: That of the run.
        shared: Folder with the FMUs of the base, and for unpacked ones; a temporary folder where it
            does not exist.
    """
    built = with_parameters_of(base, experiment)
    digest = _digest(built)
    if digest not in _kept or not _kept[digest].is_dir():
        _keep(digest, _unpackable(built, shared, is_base=digest == _digest(base)))
    _kept.move_to_end(digest)
    return {
        name: PreparedFmu(
            _kept[digest] / f"{name}.fmu",
            _kept[digest] / name,
            _start_values(name, built, experiment),
        )
        for name in _names(experiment)
    }


def _names(experiment: Experiment) -> list[str]:
    """Of the FMUs that a run is made of, without external ones."""
    names = (experiment.model_of(role) for role in experiment.roles)
    return [name for name in names if name not in experiment.fmus]


def with_parameters_of(base: Experiment, experiment: Experiment) -> Experiment:
    """The experiment with the base's values for everything that is a parameter of its FMUs."""
    if experiment.hardware.use:  # an emulated robot has no parameters but its files
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
    """Return the parameters in which a run differs from what its FMU has."""
    model = model_class(name)
    pairs = zip(model.table(built), model.table(experiment), strict=True)
    return {
        new.name: new.start
        for old, new in pairs
        if new.causality == "parameter" and old.start != new.start
    }


def _digest(experiment: Experiment) -> str:
    """Return the hash of the resources of the FMUs, and of who computes."""
    digest = hashlib.sha256(experiment.run.compute.encode())
    resources = experiment_resources(experiment, with_hardware=experiment.hardware.use)
    for name, source in sorted(resources.items()):
        content = read_contents(source)
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _unpackable(experiment: Experiment, shared: Path, *, is_base: bool) -> Path:
    """Return a folder of this process with the FMUs in it; instances unpack them into it once."""
    if shared.is_dir():
        folder = Path(tempfile.mkdtemp(dir=shared, prefix=UNPACKED))
    else:
        own = TemporaryFolder()
        atexit.register(own.remove)
        folder = own.path / "fmus"  # the other one is locked
        folder.mkdir()
    files = [shared / f"{name}.fmu" for name in _names(experiment)]
    if is_base and all(file.is_file() for file in files):
        for file in files:
            shutil.copy(file, folder)
    else:
        build(experiment, folder)
    return folder


def remove_unpacked(shared: Path) -> None:
    """Remove unpacked FMUs of all processes, ended or killed."""
    for folder in shared.glob(f"{UNPACKED}*"):
        shutil.rmtree(folder, ignore_errors=True)


def _keep(digest: str, folder: Path) -> None:
    _kept[digest] = folder
    while len(_kept) > MAX_KEPT:
        _, oldest = _kept.popitem(last=False)
        shutil.rmtree(oldest, ignore_errors=True)
