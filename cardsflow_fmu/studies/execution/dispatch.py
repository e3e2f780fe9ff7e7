"""Dispatch of runs to an executor, which tolerates the death of workers."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait

from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run

from .executors import RunExecutor
from .worker import Job

_MAX_LOST = 3  # runs that may kill their workers before the first run is complete

_ATTEMPTS = 3  # submissions of a run whose workers die

Store = Callable[[Run, Outcome], None]


def dispatch(runs: Iterable[Run], job: Job, executor: RunExecutor, store: Store) -> None:
    """Execute all runs. A run that repeatedly kills its worker fails, the others continue.

    Args:
        runs: The runs; the iterator advances when runs are submitted.
        job: Common part of the runs.
        store: Called with every run and its outcome, in the order of completion.
    """
    _Dispatcher(iter(runs), job, executor, store).execute()


class _Dispatcher:
    """State of the submitted runs and of the runs to be resubmitted.

    When a pool of processes breaks, the run that caused it is unknown. Therefore the runs of the
    pool are resubmitted one at a time, and a death only counts for a run that was alone.
    """

    def __init__(self, runs: Iterator[Run], job: Job, executor: RunExecutor, store: Store) -> None:
        self._runs, self._job, self._executor, self._store = runs, job, executor, store
        self._pending: dict[Future[Outcome], Run] = {}
        self._suspects: deque[Run] = deque()
        self._deaths: Counter[int] = Counter()
        self._lost_runs, self._any_completed = 0, False

    def execute(self) -> None:
        """Execute all runs."""
        try:
            while self._submit_due():
                done, _ = wait(self._pending, return_when=FIRST_COMPLETED)
                self._collect(done)
        finally:
            for future in self._pending:
                future.cancel()

    def _submit_due(self) -> bool:
        """Submit as many runs as possible; return whether any run is pending."""
        while not self._suspects and len(self._pending) < self._executor.window:
            run = next(self._runs, None)
            if run is None:
                break
            self._submit(run)
        if self._suspects and not self._pending:
            self._submit(self._suspects.popleft())
        return bool(self._pending)

    def _submit(self, run: Run) -> None:
        try:
            self._pending[self._executor.submit(self._job, run.settings)] = run
        except BrokenExecutor:  # it broke after the last outcome
            self._suspects.append(run)
            self._renew()

    def _collect(self, done: Iterable[Future[Outcome]]) -> None:
        was_alone = len(self._pending) == 1
        broken = False
        for future in done:
            run = self._pending.pop(future)
            try:
                outcome = future.result()
            except StudyError:
                raise
            except CancelledError:
                raise StudyError("the workers are lost") from None
            except BrokenExecutor as error:
                broken = True
                self._handle_death(run, error, counts=was_alone)
            except Exception as error:  # of another executor, or an outcome that cannot be pickled
                self._handle_death(run, error, counts=True)
            else:
                self._complete(run, outcome)
        if broken:
            self._renew()

    def _renew(self) -> None:
        """Replace the workers and store the outcomes that were completed before their death."""
        wait(self._pending)
        for future, run in self._pending.items():
            if future.cancelled() or future.exception() is not None:
                self._suspects.append(run)
            else:
                self._complete(run, future.result())
        self._pending.clear()
        self._executor.renew()

    def _handle_death(self, run: Run, error: Exception, *, counts: bool) -> None:
        """Resubmit a run whose worker died, or mark it as failed."""
        self._deaths[run.index] += counts
        times = self._deaths[run.index]
        if times < _ATTEMPTS:
            self._suspects.append(run)
            return
        self._lost_runs += 1
        if not self._any_completed and self._lost_runs == _MAX_LOST:
            raise StudyError(
                f"every run kills its worker, last error {type(error).__name__}; a script that "
                "calls run_study must do so inside `if __name__ == '__main__':`"
            )
        problem = f"its worker died {times} times, last error {type(error).__name__}"
        self._store(run, Outcome({}, problem))

    def _complete(self, run: Run, outcome: Outcome) -> None:
        self._any_completed = True
        self._store(run, outcome)
