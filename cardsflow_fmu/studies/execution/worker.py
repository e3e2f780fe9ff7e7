"""Execution of one run in a worker process; the arguments can be pickled for any executor."""

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
from cardsflow_fmu.simulation.run import simulate
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.fingerprint import experiment_digest
from cardsflow_fmu.studies.definition.metrics import metric_values
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.path_check import require_simulated
from cardsflow_fmu.studies.definition.tables import Box

_LOCK = threading.Lock()  # FMUs in a process share its working directory and signals
_digests: dict[tuple[Path, str], str] = {}


@dataclass(frozen=True, slots=True)
class Job:
    """Common part of the runs of a study, which is sent with each run."""

    experiment: Path
    digest: str
    settings: Mapping[str, Any]
    metrics: tuple[str, ...]
    box: Box | None


def execute_run(job: Job, settings: Mapping[str, Any]) -> Outcome:
    """Execute a run and return its outcome, which can be an error.

    Raises:
        StudyError: The experiment differs from the experiment of the study.
    """
    with _LOCK:
        begin = time.perf_counter()
        _check_base(job)
        try:
            experiment = Experiment.load(
                job.experiment, {**job.settings, **settings}, names_files=False
            )
            require_simulated(experiment)
            ready = time.perf_counter()
            result = simulate(experiment)
            simulated = _simulation_time(result, ready)
            metrics = metric_values(job.metrics, result, job.box)
        except CardsflowError as error:
            return Outcome({}, _one_line(error))
        except Exception as error:  # every failure is an outcome
            return Outcome({}, f"internal error: {type(error).__name__}: {_one_line(error)}")
        return Outcome(metrics, None, simulated, time.perf_counter() - begin - simulated)


def _check_base(job: Job) -> None:
    """Check that the experiment without variations is the one of the study, once per process."""
    key = job.experiment, repr(job.settings)
    if key not in _digests:
        try:
            base = Experiment.load(job.experiment, job.settings, names_files=False)
            _digests[key] = experiment_digest(base)
        except (CardsflowError, OSError) as error:
            raise StudyError(f"a worker cannot read the experiment: {error}") from None
    if _digests[key] != job.digest:
        problem = "was changed after the study began; start a new study in another folder"
        raise StudyError(f"{job.experiment}: {problem}")


def _simulation_time(result: Result, ready: float) -> float:
    factor = result.summary["real_time_factor"]
    return float(result.summary["duration"] / factor) if factor else time.perf_counter() - ready


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
