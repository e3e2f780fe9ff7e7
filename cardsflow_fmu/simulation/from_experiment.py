"""Experiments as open systems: FMUs, plain objects, or a loop in C."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from cardsflow_fmu.analysis.observable import observability_warnings, observed_poses
from cardsflow_fmu.cosim.described_fmu import DescribedFmu
from cardsflow_fmu.cosim.external_fmu import AdaptedFmu, fitting_wiring
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.step_loop import StepLoop
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.hardware.protocol.recording import RECORDING_FILE
from cardsflow_fmu.hardware.session.connect import Connection, require_connectable
from cardsflow_fmu.hardware.session.paced_run import approach_time, with_approach
from cardsflow_fmu.models.by_role import MODELS
from cardsflow_fmu.models.direct_participant import DirectParticipant, IdleParticipant
from cardsflow_fmu.models.hardware import HardwareModel
from cardsflow_fmu.models.native_loop import NativeLoop
from cardsflow_fmu.results.files import EXPERIMENT, Contents
from cardsflow_fmu.results.saved_run import experiment_archive
from cardsflow_fmu.results.summary import Speed, summarize
from cardsflow_fmu.signals.ports import outer_signals
from cardsflow_fmu.signals.roles import HARDWARE
from cardsflow_fmu.utils.archive import contents_of
from cardsflow_fmu.utils.temporary import temporary_folder

from .build import build_fmus, model_name
from .open_system import OpenSystem
from .result import Result

Through = Literal["fmu", "python", "direct", "native"]

_NATIVE: dict[Through, bool | None] = {"fmu": None, "python": False}


class PreparedFmu(NamedTuple):
    """An FMU that is built, and perhaps unpacked, for several runs.

    Attributes:
        file: The .fmu.
        folder: Where it is unpacked, or empty.
        start_values: Values of its parameters, by name; its own where left out.
    """

    file: Path
    folder: Path
    start_values: Mapping[str, float] = {}


@contextlib.contextmanager
def open_experiment(
    experiment: Experiment,
    through: Through,
    aside: Path,
    folder: Path | None,
    *,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    prepared: Mapping[str, PreparedFmu] | None = None,
) -> Iterator[OpenSystem[Result]]:
    """The participants of an experiment, with their wiring, ready to run.

    Args:
        experiment: The experiment.
        through: As for `run`.
        aside: Empty folder for temporary files.
        folder: Folder of the results; None where nothing is written.
        fmi: Version of FMI of the FMUs that are built.
        arrays: Whether FMUs of FMI 3.0 have arrays.
        prepared: FMUs that make up this experiment, by the name of the model; none is built.

    Raises:
        InputError: An FMU cannot be used, or something is not in C where all is to be.
        SimulationError: A participant does not start.
    """
    driven, fmus = experiment, prepared
    if fmus is None:
        driven = with_approach(experiment)
        fmus = {}
        if through in _NATIVE:
            fmus = _built(experiment, driven, aside, fmi, arrays, _NATIVE[through])
    contents: Contents = {}
    if folder is not None:
        contents |= {fmu.file.name: contents_of(fmu.file) for fmu in fmus.values()}
        contents[EXPERIMENT] = experiment_archive(experiment)
    hardware = driven.hardware if driven.hardware.use else None
    streamed = [RECORDING_FILE] if folder is not None and hardware is not None else []
    recording = folder / RECORDING_FILE if folder is not None and streamed else None
    with _loop(driven, through, fmus, aside, recording) as loop:
        yield OpenSystem(
            loop,
            driven.run.step,
            hardware,
            partial(_summary, driven, through, observed_poses(driven)),
            partial(Result, experiment=driven),
            contents,
            streamed,
        )


def _summary(
    experiment: Experiment,
    through: Through,
    observed: dict[str, Any],
    recording: Recording,
    speed: Speed,
) -> dict[str, Any]:
    """The summary, with what could not be observed among its warnings."""
    summary = summarize(experiment, recording, speed, through, observed)
    summary["warnings"] = [*observability_warnings(observed), *summary["warnings"]]
    return summary


def _built(
    experiment: Experiment,
    driven: Experiment,
    folder: Path,
    fmi: FmiVersion,
    arrays: bool,
    native: bool | None,
) -> dict[str, PreparedFmu]:
    """The FMUs of an experiment that may have been made to begin elsewhere."""
    names = [model_name(role, experiment) for role in experiment.roles]
    made = partial(build_fmus, fmi=fmi, arrays=arrays, native=native, sources=False)
    if driven is not experiment:  # the controller is the same wherever the robot begins
        files = made(experiment, folder, ["controller"])
        names.remove("controller")
        files = made(driven, folder, names) | files
    else:
        files = made(experiment, folder, names)
    return {name: PreparedFmu(file, folder / f"unpacked_{name}") for name, file in files.items()}


@np.errstate(over="ignore", invalid="ignore")  # as in a run
def require_openable(experiment: Experiment) -> None:
    """Refuse what a run refuses before its first step, in the same words.

    Hardware is not connected to, and no code of others is run, be it in FMUs or Python. Muscles
    with a law in Python leave nothing to look at.

    Args:
        experiment: The experiment.

    Raises:
        InputError: Something does not fit, or cannot be made.
        SimulationError: A participant does not start.
    """
    require_connectable(experiment)
    if any(muscle.model.own is not None for muscle in experiment.robot.muscles):
        return
    approach_time(experiment)
    experiment_resources(experiment)
    with temporary_folder() as aside, _participants(experiment, _idle, aside) as participants:
        _master(experiment, participants)


@contextlib.contextmanager
def _loop(
    experiment: Experiment,
    through: Through,
    fmus: Mapping[str, PreparedFmu],
    aside: Path,
    recording: Path | None,
) -> Iterator[StepLoop]:
    if through == "native":
        with NativeLoop(experiment) as loop:
            yield loop
        return
    make = partial(_started, fmus=fmus, connection=_connection(experiment, recording))
    with _participants(experiment, make, aside) as participants:
        yield _master(experiment, participants)


def _master(experiment: Experiment, participants: Mapping[str, Participant]) -> Master:
    settings = experiment.run
    return Master(
        [participants[name] for name in experiment.columns],
        fitting_wiring(
            experiment.wiring,
            experiment.fmus,
            participants.values(),
            outer_signals(experiment.robot, experiment.plant.wrenches),
        ),
        step=settings.step,
        steps=settings.steps,
        coupling=experiment.coupling,
        every={"controller": round(experiment.controller.period / settings.step)},
    )


@contextlib.contextmanager
def _participants(
    experiment: Experiment, make: Callable[[Experiment, str, Path], Participant], aside: Path
) -> Iterator[dict[str, Participant]]:
    """The participants by role, each as it is made by the role's name and an empty folder.

    The plant comes last: hardware does not wait for long.
    """
    with contextlib.ExitStack() as stack:
        participants: dict[str, Participant] = {}
        for role in reversed(experiment.roles):
            name = model_name(role, experiment)
            participant = make(experiment, role, aside / f"external_{name}")
            stack.callback(participant.close)
            if (external := experiment.fmus.get(name)) is not None:
                table = MODELS[name].table(experiment)
                participant = AdaptedFmu(participant, external, table)
            participants[role] = participant
        yield participants


def _started(
    experiment: Experiment,
    role: str,
    unpacked: Path,
    fmus: Mapping[str, PreparedFmu],
    connection: Connection,
) -> Participant:
    """An FMU where there is one, else the model itself."""
    name = model_name(role, experiment)
    external = experiment.fmus.get(name)
    with connection.exported():
        if external is not None:
            return FmuInstance(role, external.file, unpacked, external.parameters)
        if name in fmus:
            return FmuInstance(role, *fmus[name])
        if name == HARDWARE:
            return DirectParticipant(role, HardwareModel(experiment, connection=connection))
        return DirectParticipant(role, MODELS[name](experiment))


def _idle(experiment: Experiment, role: str, unpacked: Path) -> Participant:
    """The same, but of what is not ours its inputs and outputs alone."""
    name = model_name(role, experiment)
    external = experiment.fmus.get(name)
    if external is not None:
        return DescribedFmu(role, external.file, unpacked, external.parameters)
    own_law = name == "controller" and experiment.controller.own_law is not None
    if name != HARDWARE and not own_law:
        return DirectParticipant(role, MODELS[name](experiment))
    return IdleParticipant(role, MODELS[name].table(experiment))


def _connection(experiment: Experiment, recording: Path | None = None) -> Connection:
    return Connection(experiment.hardware.link, experiment.hardware.key_file, recording)
