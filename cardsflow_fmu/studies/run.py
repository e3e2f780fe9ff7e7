"""Execution of studies: runs, table, summary and report."""

from __future__ import annotations

import contextlib
import os
import string
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import CardsflowError, InputError
from addin_sdfusion.robot.files import write_files
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.results.analysis.plausibility import experiment_warnings
from cardsflow_fmu.utils.interrupts import INTERRUPTED

from .analysis.best_robot import write_best
from .analysis.statistics import collect
from .analysis.summary import study_summary, summary_text
from .analysis.table import Rows, columns_of, units_text, write_table
from .definition.errors import StudyError
from .definition.fingerprint import experiment_digest, fingerprint
from .definition.metrics import metric_units
from .definition.outcome import Outcome
from .definition.rerun_command import rerun_command
from .definition.sampling import Run, expand, run_count
from .definition.study import Study
from .execution.dispatch import dispatch
from .execution.executors import ExecutorAdapter, RunExecutor, process_executor
from .execution.optimisation import Search, optimise
from .execution.run_store import RunStore
from .execution.worker import Job, execute_run

Progress = Callable[[int, int, int], None]
"""Function that is called with the numbers of completed runs, all runs, and failed runs."""

BEST = "best"


@dataclass
class StudyResult:
    """The result of a study.

    Attributes:
        folder: Folder with runs, table and report.
        summary: Content of summary.json.
        rows: Function that returns the runs and their outcomes, in order.
        files: Written files by name, except the files of single runs.
    """

    folder: Path
    summary: dict[str, Any]
    rows: Rows
    files: dict[str, Path]


def run_study(
    study: Study,
    executor: Executor | None = None,
    *,
    jobs: int | None = None,
    resume: bool = False,
    output: str | Path | None = None,
    progress: Progress | None = None,
) -> StudyResult:
    """Execute the missing runs of a study and write table, summary and report.

    Args:
        executor: Executor of the runs, or None for a pool of processes.
        jobs: Number of parallel runs, or None for the number of cores.
        resume: Whether to continue a study that already has runs.
        output: Output folder, or None for the folder that the study specifies.
        progress: Function that is called after each run.

    Raises:
        InputError: The folder cannot be used.
        StudyError: The study stopped before its end; it can be resumed.
    """
    jobs = os.cpu_count() or 1 if jobs is None else jobs
    files = RunStore(Path(output or study.output))
    with files.locked():
        if files.hashes() and not resume:
            problem = "contains runs of a study; continue it with --resume, or use another folder"
            raise InputError(f"{problem} (-o)", file=files.folder)
        work = _StudyRun(study, files, progress)
        try:
            with _run_executor(executor, jobs) as runs:
                search = None
                if study.optimise is None:
                    work.run_samples(runs)
                else:
                    search = work.run_optimisation(runs)
            return _write_results(study, work, search)
        except (StudyError, KeyboardInterrupt) as error:
            reason = INTERRUPTED if isinstance(error, KeyboardInterrupt) else str(error)
            done = f"{work.done} of {work.total} runs are complete"
            problem = f"{reason}; {done}; use --resume to continue"
            raise StudyError(problem) from None


def repeat_run(study: Study, prefix: str, output: str | Path | None = None) -> tuple[str, Outcome]:
    """Repeat one run of a study in this process without writing files.

    Args:
        prefix: First digits of the run's hash.
        output: Folder of the study, or None for the folder that the study specifies.

    Returns:
        The command that writes all files of the run, and the outcome.

    Raises:
        InputError: The run does not exist.
    """
    files = RunStore(Path(output or study.output))
    if not set(prefix) <= set(string.hexdigits) or not prefix:
        problem = f"must be the first digits of a run's hash, not {prefix!r}"
        raise InputError(problem, key="--only")
    work = _StudyRun(study, files, None)
    runs = () if study.optimise else expand(study, work.fingerprint)
    run = next((run for run in runs if run.hash.startswith(prefix)), None)
    if run is None:
        stored = files.settings(prefix)
        if not stored:
            problem = f"no run has a hash that begins with {prefix!r}; the table lists all hashes"
            raise InputError(problem, file=study.file, key="--only")
        run = Run(0, {}, stored[0], prefix)
    return rerun_command(study, run), execute_run(work.job, run.settings)


class _StudyRun:
    """State of the execution of a study."""

    def __init__(self, study: Study, files: RunStore, progress: Progress | None) -> None:
        self.study, self.files, self._progress = study, files, progress
        self.base = Experiment.load(study.experiment, study.settings, names_files=False)
        digest = experiment_digest(self.base)
        self.fingerprint = fingerprint(study, digest)
        self.job = Job(
            study.experiment.resolve(),
            digest,
            study.settings,
            study.metrics,
            study.box,
        )
        self.total = run_count(study) if study.optimise is None else study.optimise.max_runs
        self.done = self._failed = 0

    def run_samples(self, executor: RunExecutor) -> None:
        """Execute the runs of a sampling that are not stored."""
        seen: set[str] = set()

        def missing() -> Iterator[Run]:
            for run in self.expanded():
                outcome = None if run.hash in seen else self.files.read(run)
                if outcome is None and run.hash not in seen:
                    yield run
                else:
                    self._count(outcome)
                seen.add(run.hash)

        dispatch(missing(), self.job, executor, self._store)

    def run_optimisation(self, executor: RunExecutor) -> Search:
        """Execute the generations of an optimisation."""

        def generation(runs: Iterable[Run]) -> list[Outcome]:
            runs = list(runs)
            missing = {run.hash: run for run in runs if self.files.read(run) is None}
            for _ in range(len(runs) - len(missing)):
                self._count(None)
            dispatch(missing.values(), self.job, executor, self._store)
            return [self.outcome(run) for run in runs]

        return optimise(self.study, self.fingerprint, generation)

    def expanded(self) -> Iterator[Run]:
        """Yield the runs of a sampling, in order."""
        return expand(self.study, self.fingerprint)

    def outcome(self, run: Run) -> Outcome:
        """Return the stored outcome of a run."""
        outcome = self.files.read(run)
        if outcome is None:
            problem = f"the file of run {run.hash} is missing or damaged"
            raise StudyError(f"{self.files.folder}: {problem}")
        return outcome

    def rows(self) -> Iterator[tuple[Run, Outcome]]:
        """Yield the runs of a sampling with their outcomes, in order."""
        for run in self.expanded():
            yield run, self.outcome(run)

    def _store(self, run: Run, outcome: Outcome) -> None:
        self.files.write(run, outcome)
        self._count(outcome)

    def _count(self, outcome: Outcome | None) -> None:
        self.done += 1
        self._failed += outcome is not None and not outcome.complete
        if self._progress is not None:
            self._progress(self.done, self.total, self._failed)


@contextlib.contextmanager
def _run_executor(executor: Executor | None, jobs: int) -> Iterator[RunExecutor]:
    if executor is None:
        with process_executor(jobs) as pool:
            yield pool
    else:
        yield ExecutorAdapter(executor, jobs)


def _write_results(study: Study, work: _StudyRun, search: Search | None) -> StudyResult:
    """Write tables, summary and report."""
    from .analysis.report import report_page  # the import of matplotlib takes one second

    rows: Rows = work.rows if search is None else lambda: iter(search.runs)
    columns = columns_of(study)
    collected = collect(columns, rows())
    units = metric_units(study.metrics, _tracking_unit(work.base))
    summary = study_summary(study, collected, rows)
    summary["warnings"] = experiment_warnings(work.base)
    folder = work.files.folder
    runs = work.expanded() if search is None else (run for run, _ in search.runs)
    if others := len(work.files.hashes().difference(run.hash for run in runs)):
        summary["other_runs"] = others
    if search is not None:
        summary["best"] = _write_best_run(study, search, folder)
        summary["history"] = search.history
    table = folder / "table.csv"
    write_table(table, columns, rows)
    history = None if search is None else search.history
    texts: dict[str, str | bytes] = {
        "table.units.json": units_text(columns, units),
        "report.html": report_page(study, summary, collected, units, history),
        "summary.json": summary_text(summary),
    }
    try:
        written = write_files(folder, texts)
    except CardsflowError as error:
        raise StudyError(str(error)) from None
    files = {path.name: path for path in written}
    return StudyResult(folder, summary, rows, files | {table.name: table})


def _write_best_run(study: Study, search: Search, folder: Path) -> Mapping[str, Any] | None:
    """Write the robot of the best run and return the run for the summary, or None."""
    if search.best is None:
        return None
    assert study.optimise is not None
    run, outcome = search.runs[search.best]
    experiment = Experiment.load(
        study.experiment, {**study.settings, **run.settings}, names_files=False
    )
    try:
        notes = write_best(experiment, folder / BEST)
    except CardsflowError as error:
        raise StudyError(str(error)) from None
    return {
        "run": run.index,
        "hash": run.hash,
        "objective": outcome.metrics[study.optimise.objective],
        "metrics": dict(outcome.metrics),
        "settings": dict(run.settings),
        "command": rerun_command(study, run),
        "folder": BEST,
        "notes": notes,
    }


def _tracking_unit(experiment: Experiment) -> str:
    from cardsflow_fmu.cosim.signals.tracked_signals import tracked_signals, tracking_unit

    return tracking_unit(
        tracked_signals(
            experiment.robot, experiment.reference.space, experiment.controller.uncontrolled
        )
    )
