"""Initialised and connected participants of an experiment: FMUs or models."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import Finding
from cardsflow_fmu.cosim.described_fmu import DescribedFmu
from cardsflow_fmu.cosim.external_fmu import AdaptedFmu
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.roles import HARDWARE
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.writer import experiment_resources
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.models.by_role import model_class
from cardsflow_fmu.models.direct_participant import DirectParticipant, IdleParticipant
from cardsflow_fmu.models.native_loop import experiment_master
from cardsflow_fmu.results.analysis.look_ahead import with_look_ahead
from cardsflow_fmu.results.analysis.observable import observability_warnings, observed_poses
from cardsflow_fmu.results.analysis.plausibility import plausibility_findings
from cardsflow_fmu.results.files import EXPERIMENT, RECORDING_FILE, Contents
from cardsflow_fmu.results.saved_run import experiment_archive
from cardsflow_fmu.results.summary import Speed, summarize
from cardsflow_fmu.utils.archive import read_contents
from cardsflow_fmu.utils.temporary import temporary_folder

from .build import build_fmus
from .open_system import OpenSystem
from .result import Result

if TYPE_CHECKING:
    from cardsflow_fmu.hardware.session.connect import Connection


@dataclass(frozen=True, kw_only=True)
class OpenExperiment(OpenSystem[Result]):
    """Experiment with initialised participants.

    Attributes:
        experiment: The experiment, with the approach motion of hardware.
        observed: Observability of the reference poses, from `analysis.observable`.
        findings: Findings about unlikely settings.
    """

    experiment: Experiment
    observed: dict[str, Any]
    findings: Sequence[Finding]

    def summary(self, recording: Recording, speed: Speed) -> dict[str, Any]:
        """Return the summary of a recording; see `OpenSystem.summary`."""
        summary = summarize(self.experiment, recording, speed, self.observed)
        unlikely = [finding.located for finding in self.findings]
        summary["warnings"] = [
            *observability_warnings(self.observed),
            *unlikely,
            *summary["warnings"],
        ]
        return summary

    def result(self, recording: Recording, summary: dict[str, Any]) -> Result:
        """Return the result of a recording."""
        return Result(
            recording.names,
            recording.rows,
            recording.units,
            summary,
            solve_times=recording.times_of_ticks(),
            experiment=self.experiment,
        )


@contextlib.contextmanager
def open_experiment(
    experiment: Experiment,
    scratch: Path,
    folder: Path | None,
    *,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
) -> Iterator[OpenExperiment]:
    """Start and connect the participants of an experiment.

    Args:
        experiment: The experiment; `run.compute` and `run.coupling` specify how it runs.
        scratch: Empty folder for temporary files.
        folder: Results folder; None to write nothing.
        fmi: FMI version of the FMUs.
        arrays: Whether FMUs of FMI 3.0 have arrays.

    Raises:
        InputError: An FMU is invalid.
        SimulationError: A participant does not start.
    """
    driven, fmus = experiment, dict[str, Path]()
    if experiment.hardware.use:
        from cardsflow_fmu.hardware.session.approach import with_approach

        driven = with_approach(experiment)
    driven = with_look_ahead(driven)
    if experiment.run.coupling == "fmu":
        fmus = _build_fmus(experiment, driven, scratch, fmi, arrays)
    contents: Contents = {}
    if folder is not None:
        contents |= {file.name: read_contents(file) for file in fmus.values()}
        contents[EXPERIMENT] = experiment_archive(experiment)
    streamed = [RECORDING_FILE] if folder is not None and driven.hardware.use else []
    connection = _connection(driven, folder if streamed else None)
    with contextlib.ExitStack() as stack:
        participants: dict[str, Participant] = {}
        for role in reversed(driven.roles):  # the plant last: hardware only waits for a short time
            with contextlib.nullcontext() if connection is None else connection.exported():
                participant = _start_participant(driven, role, scratch, fmus, connection)
            stack.callback(participant.close)
            participants[role] = _adapt(driven, role, participant)
        loop = experiment_master(driven, participants)
        observed = {} if driven.estimator is None else observed_poses(driven)
        findings = [] if folder is None else plausibility_findings(experiment)
        yield OpenExperiment(
            experiment=driven,
            loop=loop,
            step=driven.run.step,
            hardware=driven.hardware if driven.hardware.use else None,
            table_format=driven.run.format,
            contents=contents,
            streamed=streamed,
            observed=observed,
            findings=findings,
        )


@np.errstate(over="ignore", invalid="ignore")  # as in a run
def require_openable(experiment: Experiment) -> None:
    """Raise the errors that a run raises before its first step.

    The check does not connect to hardware and does not execute third-party code, neither FMUs nor
    Python files. Experiments with custom muscle laws are not checked.

    Raises:
        InputError: A part of the experiment is invalid.
        SimulationError: A participant does not start.
    """
    if experiment.hardware.use:
        from cardsflow_fmu.hardware.session.approach import approach_time
        from cardsflow_fmu.hardware.session.connect import require_connectable

        require_connectable(experiment)
        approach_time(experiment)
    if any(muscle.model.custom is not None for muscle in experiment.robot.muscles):
        return
    experiment_resources(experiment)
    with temporary_folder() as scratch, contextlib.ExitStack() as stack:
        participants: dict[str, Participant] = {}
        for role in reversed(experiment.roles):
            participant = _placeholder(experiment, role, scratch)
            stack.callback(participant.close)
            participants[role] = _adapt(experiment, role, participant)
        experiment_master(experiment, participants)


def _build_fmus(
    experiment: Experiment, driven: Experiment, folder: Path, fmi: FmiVersion, arrays: bool
) -> dict[str, Path]:
    """Build the FMUs of an experiment; `driven` includes the approach motion of hardware."""
    names = [experiment.model_of(role) for role in experiment.roles]
    native = None if experiment.run.compute == "c" else False
    files: dict[str, Path] = {}
    if driven is not experiment and not driven.reacts_to_faults:
        # The controller does not depend on the start.
        names.remove("controller")
        files |= build_fmus(
            experiment, folder, ["controller"], fmi, arrays, native=native, sources=False
        )
    return files | build_fmus(driven, folder, names, fmi, arrays, native=native, sources=False)


def _connection(experiment: Experiment, folder: Path | None) -> Connection | None:
    """Return the connection to the hardware, with its recording; None without hardware."""
    hardware = experiment.hardware
    if not (hardware.use or hardware.link):
        return None
    from cardsflow_fmu.hardware.session.connect import Connection

    recording = None if folder is None else folder / RECORDING_FILE
    return Connection(hardware.link, hardware.key_file, recording)


def _start_participant(
    experiment: Experiment,
    role: str,
    scratch: Path,
    fmus: Mapping[str, Path],
    connection: Connection | None,
) -> Participant:
    """Start the FMU of a role, or its model."""
    name = experiment.model_of(role)
    if (external := experiment.fmus.get(name)) is not None:
        unpacked = scratch / f"external_{name}"
        return FmuInstance(role, external.file, unpacked, external.parameters)
    if name in fmus:
        return FmuInstance(role, fmus[name], scratch / f"unpacked_{name}")
    if name == HARDWARE:
        from cardsflow_fmu.models.hardware import HardwareModel

        return DirectParticipant(role, HardwareModel(experiment, connection=connection))
    return DirectParticipant(role, model_class(name)(experiment))


def _placeholder(experiment: Experiment, role: str, scratch: Path) -> Participant:
    """Return the participant of a role; third-party code is replaced by its inputs and outputs."""
    name = experiment.model_of(role)
    if (external := experiment.fmus.get(name)) is not None:
        unpacked = scratch / f"external_{name}"
        return DescribedFmu(role, external.file, unpacked, external.parameters)
    own_law = name == "controller" and experiment.controller.custom_law is not None
    if name != HARDWARE and not own_law:
        return DirectParticipant(role, model_class(name)(experiment))
    return IdleParticipant(role, model_class(name).table(experiment))


def _adapt(experiment: Experiment, role: str, participant: Participant) -> Participant:
    """Adapt an external FMU to the names and units of the experiment."""
    name = experiment.model_of(role)
    external = experiment.fmus.get(name)
    if external is None:
        return participant
    return AdaptedFmu(participant, external, model_class(name).table(experiment))
