"""Studies from their definition to runs, table and report."""

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
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.utils.interrupts import INTERRUPTED

from .analysis.best_robot import write_best
from .analysis.statistics import collect
from .analysis.summary import study_summary, summary_text
from .analysis.table import Rows, columns_of, units_text, write_tables
from .definition.errors import StudyError
from .definition.fingerprint import experiment_digest, fingerprint
from .definition.metrics import metric_units
from .definition.outcome import Outcome
from .definition.rerun_command import rerun_command
from .definition.sampling import Run, expand, run_count
from .definition.study import Study
from .execution.dispatch import dispatch
from .execution.executors import ExecutorAdapter, RunExecutor, process_executor
from .execution.fmu_cache import remove_unpacked
from .execution.optimisation import Search, optimise
from .execution.run_store import RunStore
from .execution.worker import Job, do_run

Progress = Callable[[int, int, int], None]
"""Called with the runs done, all runs, and the failed ones among those done."""

BEST = "best"


@dataclass
class StudyResult:
    """The result of a study.

    Attributes:
        folder: Where runs, table and report are.
        summary: Content of summary.json.
        rows: Gives the runs and their outcomes, in order.
        files: Files by name, without those of single runs.
    """

    folder: Path
    summary: dict[str, Any]
    rows: Rows
    files: dict[str, Path]


def run_study(
    study: Study,
    executor: Executor | RunExecutor | None = None,
    *,
    jobs: int | None = None,
    resume: bool = False,
    output: str | Path | None = None,
    progress: Progress | None = None,
) -> StudyResult:
    """Do the runs of a study that are not yet done; write table, summary and report.

    Args:
        study: The study.
        executor: Executor of the runs; a pool of processes when None.
        jobs: Number of runs at once; one a core when None.
        resume: Whether to continue a study that has runs already.
        output: Folder for everything; the study's own when None.
        progress: Called when a run is done.

    Raises:
        InputError: The folder cannot be used.
        StudyError: The study stopped before its end; it can be resumed.
    """
    jobs = os.cpu_count() or 1 if jobs is None else jobs
    files = RunStore(Path(output or study.output))
    with files.locked():
        if files.hashes() and not resume:
            what = "holds runs of a study: go on with --resume, or choose another folder with -o"
            raise InputError(what, file=files.folder)
        work = _StudyRun(study, files, progress)
        try:
            with _run_executor(executor, jobs) as runs:
                search = None
                if study.optimise is None:
                    work.sampled(runs)
                else:
                    search = work.optimised(runs)
            return _finished(study, work, search)
        except (StudyError, KeyboardInterrupt) as error:
            reason = INTERRUPTED if isinstance(error, KeyboardInterrupt) else str(error)
            what = f"{reason}; {work.done} of {work.total} runs are done, --resume goes on"
            raise StudyError(what) from None
        finally:
            remove_unpacked(work.job.fmus)


def only_run(study: Study, beginning: str, output: str | Path | None = None) -> tuple[str, Outcome]:
    """Repeat one run of a study, in this process, and write nothing.

    Args:
        study: The study.
        beginning: The begin of the run's hash.
        output: Folder of the study; its own when None.

    Returns:
        The command that writes all files of the run, and the outcome.

    Raises:
        InputError: There is no such run.
    """
    files = RunStore(Path(output or study.output))
    if not set(beginning) <= set(string.hexdigits) or not beginning:
        raise InputError(f"must be the begin of a run's hash, not {beginning!r}", key="--only")
    work = _StudyRun(study, files, None)
    runs = () if study.optimise else expand(study, work.fingerprint)
    run = next((run for run in runs if run.hash.startswith(beginning)), None)
    if run is None:
        there = files.settings(beginning)
        if not there:
            what = f"no run has a hash that begins with {beginning!r}; the table lists them"
            raise InputError(what, file=study.file, key="--only")
        run = Run(0, {}, there[0], beginning)
    return rerun_command(study, run), do_run(work.job, run.settings)


class _StudyRun:
    """The progress of a study."""

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
            files.folder.resolve() / "fmus",
        )
        self.total = run_count(study) if study.optimise is None else study.optimise.most_runs
        self.done = self._failed = 0

    def sampled(self, executor: RunExecutor) -> None:
        """Do the runs of a sampling that have no file."""
        self._build()
        seen: set[str] = set()

        def missing() -> Iterator[Run]:
            for run in self.expanded():
                outcome = None if run.hash in seen else self.files.read(run)
                if outcome is None and run.hash not in seen:
                    yield run
                else:
                    self._count(outcome)
                seen.add(run.hash)

        dispatch(missing(), self.job, executor, self._keep)

    def optimised(self, executor: RunExecutor) -> Search:
        """Do the generations of an optimisation."""
        self._build()

        def generation(runs: Iterable[Run]) -> list[Outcome]:
            runs = list(runs)
            missing = {run.hash: run for run in runs if self.files.read(run) is None}
            for _ in range(len(runs) - len(missing)):
                self._count(None)
            dispatch(missing.values(), self.job, executor, self._keep)
            return [self.outcome(run) for run in runs]

        return optimise(self.study, self.fingerprint, generation)

    def expanded(self) -> Iterator[Run]:
        """The runs of a sampling, in order."""
        return expand(self.study, self.fingerprint)

    def outcome(self, run: Run) -> Outcome:
        """Return the outcome of a run that is done."""
        outcome = self.files.read(run)
        if outcome is None:
            raise StudyError(f"{self.files.folder}: the file of run {run.hash} is gone or damaged")
        return outcome

    def rows(self) -> Iterator[tuple[Run, Outcome]]:
        """The runs of a sampling with their outcomes, in order."""
        for run in self.expanded():
            yield run, self.outcome(run)

    def _build(self) -> None:
        if self.study.coupling == "fmu":
            remove_unpacked(self.job.fmus)
            build(self.base, self.job.fmus)

    def _keep(self, run: Run, outcome: Outcome) -> None:
        self.files.write(run, outcome)
        self._count(outcome)

    def _count(self, outcome: Outcome | None) -> None:
        self.done += 1
        self._failed += outcome is not None and not outcome.complete
        if self._progress is not None:
            self._progress(self.done, self.total, self._failed)


@contextlib.contextmanager
def _run_executor(executor: Executor | RunExecutor | None, jobs: int) -> Iterator[RunExecutor]:
    if executor is None:
        with process_executor(jobs) as own:
            yield own
    else:
        yield ExecutorAdapter(executor, jobs) if isinstance(executor, Executor) else executor


def _finished(study: Study, work: _StudyRun, search: Search | None) -> StudyResult:
    """Write tables, summary and report."""
    from .analysis.report import report_page  # matplotlib takes a second to import

    rows: Rows = work.rows if search is None else lambda: iter(search.runs)
    columns = columns_of(study)
    collected = collect(columns, rows())
    units = metric_units(study.metrics, _tracking_unit(work.base))
    summary = study_summary(study, collected, rows)
    folder = work.files.folder
    own = work.expanded() if search is None else (run for run, _ in search.runs)
    if others := len(work.files.hashes().difference(run.hash for run in own)):
        summary["other_runs"] = others
    if search is not None:
        summary["best"] = _best(study, search, folder)
        summary["history"] = search.history
    write_tables(folder, study.tables, columns, rows)
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
    files |= {f"table.{kind}": folder / f"table.{kind}" for kind in study.tables}
    return StudyResult(folder, summary, rows, files)


def _best(study: Study, search: Search, folder: Path) -> Mapping[str, Any] | None:
    """Return the best run, and its robot in files."""
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
    """Return the unit of the tracking error."""
    from cardsflow_fmu.cosim.signals.followed import followed_signals, tracking_unit

    return tracking_unit(
        followed_signals(
            experiment.robot, experiment.reference.space, experiment.controller.uncontrolled
        )
    )
