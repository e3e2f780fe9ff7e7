"""One run in a worker process: a function of plain arguments, for any executor."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.simulation.result import Result
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.fingerprint import experiment_digest
from cardsflow_fmu.studies.definition.metrics import metric_values
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.path_check import require_simulated
from cardsflow_fmu.studies.definition.tables import Box

_ONE_AT_A_TIME = threading.Lock()  # FMUs share their process' folder and signals
_bases: dict[tuple[Path, str], tuple[Experiment, str]] = {}


@dataclass(frozen=True, slots=True)
class Job:
    """The common part of the runs of a study, small enough to be sent with each.

    Attributes:
        experiment: The experiment.toml, or the folder that holds one.
        digest: Of the experiment, see `experiment_digest`.
        settings: Common changes of its settings.
        metrics: Names of the metrics.
        box: The box of the workspace.
        fmus: Folder with the built FMUs of the experiment; they are built again if it does not
            exist.
    """

    experiment: Path
    digest: str
    settings: Mapping[str, Any]
    metrics: tuple[str, ...]
    box: Box | None
    fmus: Path


def do_run(job: Job, settings: Mapping[str, Any]) -> Outcome:
    """Do a run; an error is an outcome.

    Raises:
        StudyError: The experiment differs from that of the study.
    """
    with _ONE_AT_A_TIME:
        begin = time.perf_counter()
        base = _base(job)
        try:
            experiment = Experiment.load(
                job.experiment, {**job.settings, **settings}, names_files=False
            )
            require_simulated(experiment)
            ready = time.perf_counter()
            result = _simulate(job, base, experiment)
            simulated = _simulated(result, ready)
            metrics = metric_values(job.metrics, result, job.box)
        except CardsflowError as error:
            return Outcome({}, _one_line(error))
        except Exception as error:  # any failure is a row
            return Outcome({}, f"internal error: {type(error).__name__}: {_one_line(error)}")
        return Outcome(metrics, None, simulated, time.perf_counter() - begin - simulated)


def _base(job: Job) -> Experiment:
    """Return the experiment without variations, read once in a process.

    Raises:
        StudyError: It differs from that of the study.
    """
    key = job.experiment, repr(job.settings)
    if key not in _bases:
        try:
            base = Experiment.load(job.experiment, job.settings, names_files=False)
            _bases[key] = base, experiment_digest(base)
        except (CardsflowError, OSError) as error:
            raise StudyError(f"the experiment cannot be read by a worker: {error}") from None
    base, digest = _bases[key]
    if digest != job.digest:
        what = "is not the experiment that the study began with: begin anew in another folder"
        raise StudyError(f"{job.experiment}: {what}")
    return base


def _simulate(job: Job, base: Experiment, experiment: Experiment) -> Result:
    from cardsflow_fmu.simulation.run import simulate

    from .fmu_cache import prepared_fmus

    if experiment.run.coupling == "fmu":
        return simulate(experiment, prepared=prepared_fmus(base, experiment, job.fmus))
    return simulate(experiment)


def _simulated(result: Result, ready: float) -> float:
    """Time of the steps, in [s]."""
    factor = result.summary["real_time_factor"]
    return float(result.summary["duration"] / factor) if factor else time.perf_counter() - ready


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
