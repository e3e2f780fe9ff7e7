"""Runs that kill the process they are done in."""

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
    """Dies of gains below 0, and otherwise gives them back."""
    if settings[DEADLY] < 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome({"force.peak": settings[DEADLY]})


class DeadlyExecutor(ProcessExecutor):
    """Processes that do deadly runs."""

    def submit(self, job: Job, settings: Mapping[str, Any]) -> Future[Outcome]:
        """Hand out a deadly run."""
        return self._pool.submit(deadly_run, job, settings)
