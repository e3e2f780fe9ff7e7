"""Executors of runs: a pool of processes, or an adapter for another executor."""

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

from .worker import Job, execute_run

_PER_WORKER = 2  # runs submitted per worker, so that workers are never idle
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class RunExecutor(Protocol):
    """An executor of runs.

    Attributes:
        window: Maximum number of pending runs.
    """

    window: int

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""

    def renew(self) -> None:
        """Replace workers that have died."""


class ProcessExecutor:
    """A pool of new interpreter processes with one thread each.

    The processes end immediately on Ctrl-C and when this process ends or is killed.
    """

    def __init__(self, jobs: int) -> None:
        self.window = _PER_WORKER * jobs
        self._jobs = jobs
        self._context = multiprocessing.get_context("spawn")
        self._open()

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""
        with _single_threaded():
            return self._pool.submit(execute_run, job, settings)

    def renew(self) -> None:
        """Replace the processes."""
        self.close()
        self._open()

    def close(self) -> None:
        """End the processes immediately."""
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
    """An adapter for an executor that the caller opens and closes."""

    def __init__(self, executor: Executor, workers: int) -> None:
        self.window = _PER_WORKER * workers
        self._executor = executor

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run."""
        try:
            return self._executor.submit(execute_run, job, settings)
        except RuntimeError as error:
            raise StudyError(f"the executor rejects further runs: {error}") from None

    def renew(self) -> None:
        """Raise StudyError, since the caller owns the workers."""
        raise StudyError("the executor has lost its workers")


MAX_JOBS = 1024
"""Maximum number of processes in a pool."""


@contextlib.contextmanager
def process_executor(jobs: int) -> Iterator[ProcessExecutor]:
    """Return a pool of processes, as a context.

    Raises:
        InputError: The number of processes is not positive or exceeds `MAX_JOBS`.
    """
    if not 1 <= jobs <= MAX_JOBS:
        limit = "at least 1" if jobs < 1 else f"at most {MAX_JOBS}"
        raise InputError(f"must be {limit}, not {jobs}", key="jobs")
    with contextlib.closing(ProcessExecutor(jobs)) as executor:
        yield executor


def _begin_worker(watched: Connection) -> None:
    """Initialise a worker: ignore signals, which the parent handles, and exit with the parent."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    threading.Thread(target=_exit_with_parent, args=(watched,), daemon=True).start()


def _exit_with_parent(watched: Connection) -> None:
    """Exit when the parent closes the pipe or dies; the parent never sends data."""
    watched.poll(None)
    os._exit(1)


@contextlib.contextmanager
def _single_threaded() -> Iterator[None]:
    """Set single-threaded numerical libraries for processes that start in this context."""
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
