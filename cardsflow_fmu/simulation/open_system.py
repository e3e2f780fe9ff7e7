"""Base class of experiments and .ssp files with initialised participants."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.settings.run import TableFormat
from cardsflow_fmu.results.files import Contents
from cardsflow_fmu.results.summary import Speed

from .result import SystemResult

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.settings.hardware import HardwareSettings

R = TypeVar("R", bound=SystemResult)


@dataclass(frozen=True, kw_only=True)
class OpenSystem(ABC, Generic[R]):
    """Initialised participants: an `OpenExperiment` or an `OpenSsp`.

    Attributes:
        loop: Loop that steps the participants.
        step: Communication step, in [s].
        hardware: Hardware of the run; None without hardware, or if unknown.
        contents: Other files of the results folder, by name; empty without a folder.
        streamed: Names of files that participants write into the folder.
    """

    loop: Master
    step: float
    hardware: HardwareSettings | None
    table_format: TableFormat = "auto"
    contents: Contents
    streamed: list[str]

    @abstractmethod
    def summary(self, recording: Recording, speed: Speed) -> dict[str, Any]:
        """Return the summary of a recording, with all warnings that were known before the run."""

    @abstractmethod
    def result(self, recording: Recording, summary: dict[str, Any]) -> R:
        """Return the result of a recording."""
