"""Handing out runs and taking in their outcomes: few at a time, and dead workers survived."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait

from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run

from .executors import Crew
from .worker import Job

_GIVE_UP = 3  # so many runs whose workers died, and not one that ended, and the study stops

Keep = Callable[[Run, Outcome], None]


def perform(runs: Iterable[Run], job: Job, crew: Crew, keep: Keep) -> None:
    """Do all runs; a run that keeps killing its worker fails, and the others go on.

    Args:
        runs: Taken one by one, as they are handed out.
        job: What they have in common.
        crew: Who does them.
        keep: Called with every run and its outcome, in the order in which they end.

    Raises:
        StudyError: There is no going on.
    """
    _Performance(iter(runs), job, crew, keep).go()


class _Performance:
    """What is handed out, and what is waiting.

    When a pool of processes breaks, nobody knows which of its runs did it: they are handed out
    again one at a time, and the one that is alone when the pool breaks is the one that counts.
    """

    def __init__(self, runs: Iterator[Run], job: Job, crew: Crew, keep: Keep) -> None:
        self._runs, self._job, self._crew, self._keep = runs, job, crew, keep
        self._pending: dict[Future[Outcome], Run] = {}
        self._suspects: deque[Run] = deque()
        self._deaths: Counter[int] = Counter()
        self._given_up, self._any_ended = 0, False

    def go(self) -> None:
        """Until nothing is left."""
        try:
            while self._hand_out():
                done, _ = wait(self._pending, return_when=FIRST_COMPLETED)
                self._take_in(done)
        finally:
            for future in self._pending:
                future.cancel()

    def _hand_out(self) -> bool:
        """Hand out what may be; whether something is out."""
        while not self._suspects and len(self._pending) < self._crew.window:
            run = next(self._runs, None)
            if run is None:
                break
            self._submit(run)
        if self._suspects and not self._pending:
            self._submit(self._suspects.popleft())
        return bool(self._pending)

    def _submit(self, run: Run) -> None:
        try:
            self._pending[self._crew.submit(self._job, run.settings)] = run
        except BrokenExecutor:  # broken since the last outcome was taken in
            self._suspects.append(run)
            self._renew()

    def _take_in(self, done: Iterable[Future[Outcome]]) -> None:
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
        """New workers; what had ended before the old ones died is taken in."""
        wait(self._pending)
        for future, run in self._pending.items():
            if future.cancelled() or future.exception() is not None:
                self._suspects.append(run)
            else:
                self._ended(run, future.result())
        self._pending.clear()
        self._crew.renew()

    def _lost(self, run: Run, error: Exception, *, counts: bool) -> None:
        """A run whose worker died goes back, or fails."""
        self._deaths[run.index] += counts
        times = self._deaths[run.index]
        if times < self._crew.attempts:
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
