"""Open systems: initialised participants, ready to be run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.step_loop import StepLoop
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.results.files import Contents
from cardsflow_fmu.results.summary import Speed

from .result import SystemResult

R = TypeVar("R", bound=SystemResult)


@dataclass(frozen=True)
class OpenSystem(Generic[R]):
    """Participants, initialised, with what a run of them is described by.

    Attributes:
        loop: Steps the participants.
        step: Communication step, in [s].
        hardware: Hardware that takes part; None where there is none, or it is not known.
        summarize: Makes the summary of a recording.
        result: Makes the result of names, rows, units, summary and `solve_times`.
        contents: Files of the run beside its table, by name; empty where nothing is written.
        streamed: Names of the files that participants write into the folder.
    """

    loop: StepLoop
    step: float
    hardware: HardwareSettings | None
    summarize: Callable[[Recording, Speed], dict[str, Any]]
    result: Callable[..., R]
    contents: Contents
    streamed: Sequence[str]


Opener = Callable[[Path, Path | None], AbstractContextManager[OpenSystem[R]]]
"""Opens a system; takes a folder for temporary files, and that of the results or None."""
