"""Experiments as open systems: FMUs, plain objects, or a loop in C."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

from cardsflow_fmu.analysis.observable import observability_warnings, observed_poses
from cardsflow_fmu.cosim.external_fmu import AdaptedFmu, fitting_wiring
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.step_loop import StepLoop
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.hardware.protocol.recording import RECORDING_FILE
from cardsflow_fmu.hardware.session.connect import Connection
from cardsflow_fmu.hardware.session.paced_run import with_approach
from cardsflow_fmu.models.direct_participant import DirectParticipant
from cardsflow_fmu.models.hardware import HardwareModel
from cardsflow_fmu.native.loop import NativeLoop
from cardsflow_fmu.results.files import EXPERIMENT, Contents
from cardsflow_fmu.results.saved_run import experiment_archive
from cardsflow_fmu.results.summary import Speed, summarize
from cardsflow_fmu.signals.ports import outer_signals
from cardsflow_fmu.signals.roles import HARDWARE
from cardsflow_fmu.utils.archive import contents_of

from .build import MODELS, build_fmus, model_name
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
    settings = experiment.run
    with _participants(experiment, fmus, aside, recording) as participants:
        yield Master(
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
    experiment: Experiment, fmus: Mapping[str, PreparedFmu], aside: Path, recording: Path | None
) -> Iterator[dict[str, Participant]]:
    """The participants by role: an FMU where there is one, else the model itself.

    The plant comes last: hardware does not wait for long.
    """
    hardware = experiment.hardware
    connection = Connection(hardware.link, hardware.key_file, recording)
    with contextlib.ExitStack() as stack:
        participants: dict[str, Participant] = {}
        for role in reversed(experiment.roles):
            name = model_name(role, experiment)
            model, external = MODELS[name], experiment.fmus.get(name)
            participant: Participant
            with connection.exported():
                if external is not None:
                    unpacked = aside / f"external_{name}"
                    participant = FmuInstance(role, external.file, unpacked, external.parameters)
                elif name in fmus:
                    participant = FmuInstance(role, *fmus[name])
                elif name == HARDWARE:
                    made = HardwareModel(experiment, connection=connection)
                    participant = DirectParticipant(role, made)
                else:
                    participant = DirectParticipant(role, model(experiment))
            stack.callback(participant.close)
            if external is not None:
                participant = AdaptedFmu(participant, external, model.table(experiment))
            participants[role] = participant
        yield participants
