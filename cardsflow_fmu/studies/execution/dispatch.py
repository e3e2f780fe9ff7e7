"""The dispatch of runs to an executor, which survives the death of workers."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait

from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run

from .executors import RunExecutor
from .worker import Job

_GIVE_UP = 3  # runs whose workers died, without one that ended, until the study stops

Keep = Callable[[Run, Outcome], None]


def dispatch(runs: Iterable[Run], job: Job, executor: RunExecutor, keep: Keep) -> None:
    """Do all runs; a run that kills its worker repeatedly fails, and the others continue.

    Args:
        runs: The runs, read as they are submitted.
        job: Their common part.
        executor: Their executor.
        keep: Called with every run and its outcome, in the order of completion.

    Raises:
        StudyError: The runs cannot continue.
    """
    _Dispatcher(iter(runs), job, executor, keep).go()


class _Dispatcher:
    """The runs that are submitted, and those to be submitted again.

    When a pool of processes breaks, the run that broke it is not known: its runs are submitted
    again one at a time, and a death counts for the run that is alone.
    """

    def __init__(self, runs: Iterator[Run], job: Job, executor: RunExecutor, keep: Keep) -> None:
        self._runs, self._job, self._executor, self._keep = runs, job, executor, keep
        self._pending: dict[Future[Outcome], Run] = {}
        self._suspects: deque[Run] = deque()
        self._deaths: Counter[int] = Counter()
        self._given_up, self._any_ended = 0, False

    def go(self) -> None:
        """Do all runs."""
        try:
            while self._submit_due():
                done, _ = wait(self._pending, return_when=FIRST_COMPLETED)
                self._collect(done)
        finally:
            for future in self._pending:
                future.cancel()

    def _submit_due(self) -> bool:
        """Submit as many runs as may be; returns whether any is under way."""
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
        except BrokenExecutor:  # broken since the last outcome
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
                self._lost(run, error, counts=was_alone)
            except Exception as error:  # Dask's KilledWorker, or what a worker cannot send
                self._lost(run, error, counts=True)
            else:
                self._ended(run, outcome)
        if broken:
            self._renew()

    def _renew(self) -> None:
        """Replace the workers; outcomes from before their death are kept."""
        wait(self._pending)
        for future, run in self._pending.items():
            if future.cancelled() or future.exception() is not None:
                self._suspects.append(run)
            else:
                self._ended(run, future.result())
        self._pending.clear()
        self._executor.renew()

    def _lost(self, run: Run, error: Exception, *, counts: bool) -> None:
        """Resubmit a run whose worker died, or let it fail."""
        self._deaths[run.index] += counts
        times = self._deaths[run.index]
        if times < self._executor.attempts:
            self._suspects.append(run)
            return
        self._given_up += 1
        if not self._any_ended and self._given_up == _GIVE_UP:
            raise StudyError(
                f"workers die of every run, at last of {type(error).__name__}; a script that calls "
                "run_study needs `if __name__ == '__main__':` around it"
            )
        what = f"its worker died {times} times, at last of {type(error).__name__}"
        self._keep(run, Outcome({}, what))

    def _ended(self, run: Run, outcome: Outcome) -> None:
        self._any_ended = True
        self._keep(run, outcome)
