"""Runs that kill their process."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from concurrent.futures import Future
from typing import Any

from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.execution.executors import ProcessExecutor
from cardsflow_fmu.studies.execution.worker import Job

DEADLY = "controller.kp"


def deadly_run(job: Job, settings: Mapping[str, Any]) -> Outcome:
    """Kill the process for negative gains, otherwise return the gain."""
    if settings[DEADLY] < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome({"force.peak": settings[DEADLY]})


class DeadlyExecutor(ProcessExecutor):
    """Executor whose runs can kill their processes."""

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Submit a run that can kill its process."""
        return self._pool.submit(deadly_run, job, settings)
