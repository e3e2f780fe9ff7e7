"""Executors of runs: a pool of own processes, or an adapter of any other executor."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing.connection import Connection
from typing import Any, Protocol

from addin_sdfusion.robot import InputError
from cardsflow_fmu.studies.definition.errors import StudyError
from cardsflow_fmu.studies.definition.outcome import Outcome

from .worker import Job, do_run

_PER_WORKER = 2  # runs queued for a worker, so that it never idles
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class RunExecutor(Protocol):
    """An executor of runs.

    Attributes:
        window: Number of runs to submit at once.
        attempts: Number of times that a run is submitted whose worker dies.
    """

    window: int
    attempts: int

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""

    def renew(self) -> None:
        """Go on after workers have died.

        Raises:
            StudyError: There is no going on.
        """


class ProcessExecutor:
    """A pool of own processes, fresh interpreters with one thread each.

    Ctrl-C and the end of this process, of whatever kind, end them at once.
    """

    attempts = 3

    def __init__(self, jobs: int) -> None:
        self.window = _PER_WORKER * jobs
        self._jobs = jobs
        self._context = multiprocessing.get_context("spawn")
        self._open()

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""
        with _single_threaded():
            return self._pool.submit(do_run, job, settings)

    def renew(self) -> None:
        """Replace the processes."""
        self.close()
        self._open()

    def close(self) -> None:
        """End the processes at once."""
        self._lifeline.close()
        self._pool.shutdown(wait=True, cancel_futures=True)
        self._watched.close()

    def _open(self) -> None:
        self._watched, self._lifeline = self._context.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(
            self._jobs,
            mp_context=self._context,
            initializer=_begin_worker,
            initargs=(self._watched,),
        )


class ExecutorAdapter:
    """An adapter of an executor that the caller opens and closes.

    Args:
        executor: The executor.
        workers: Number of its workers.
        attempts: Number of times that a run is submitted whose worker dies.
    """

    def __init__(self, executor: Executor, workers: int, attempts: int = 3) -> None:
        self.window = _PER_WORKER * workers
        self.attempts = attempts
        self._executor = executor

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""
        try:
            return self._executor.submit(do_run, job, settings)
        except RuntimeError as error:
            raise StudyError(f"the executor takes no more runs: {error}") from None

    def renew(self) -> None:
        """Not possible."""
        raise StudyError("the executor has lost its workers")


MAX_JOBS = 1024
"""Of a pool of processes."""


@contextlib.contextmanager
def process_executor(jobs: int) -> Iterator[ProcessExecutor]:
    """A pool of processes, as a context.

    Raises:
        InputError: The number is not positive, or no machine has so many cores.
    """
    if not 1 <= jobs <= MAX_JOBS:
        limit = "at least 1" if jobs < 1 else f"at most {MAX_JOBS}"
        raise InputError(f"must be {limit}, not {jobs}", key="jobs")
    with contextlib.closing(ProcessExecutor(jobs)) as executor:
        yield executor


def _begin_worker(watched: Connection) -> None:
    """Initialise a worker: the parent handles Ctrl-C, and its end is the worker's."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    threading.Thread(target=_end_with, args=(watched,), daemon=True).start()


def _end_with(watched: Connection) -> None:
    """Exit at the end of the pipe, when the parent closes it or dies; nothing is ever sent."""
    watched.poll(None)
    os._exit(1)


@contextlib.contextmanager
def _single_threaded() -> Iterator[None]:
    """Processes that start meanwhile use one thread in their numerical libraries."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
