"""Runs by the clock: the approach of hardware, the pace of steps, the report."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from typing import Any, Self

import numpy as np

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.pacing import Pacer, real_time_priority, timeliness, without_collections
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.experiment.settings.plant import StartSettings
from cardsflow_fmu.experiment.settings.reference import ApproachSettings
from cardsflow_fmu.hardware.protocol.errors import HardwareError
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import MusclePaths

from .connect import measured_positions


def with_approach(experiment: Experiment) -> Experiment:
    """The experiment with an approach from the measured positions, if it asks for one.

    The run is longer by the duration of the approach; an approach of the reference is replaced.

    Raises:
        HardwareError: The hardware does not answer.
        InputError: The reference is an external FMU, which begins where it begins.
    """
    seconds = approach_time(experiment)
    if seconds is None:
        return experiment
    q = measured_positions(experiment)
    reference, run = experiment.reference, experiment.run
    before = reference.approach.duration if reference.approach else 0.0
    begin = q if reference.space == "joint" else _task_position(experiment, q)
    return replace(
        experiment,
        start=StartSettings(q=q, qd=(0.0,) * len(q)),
        reference=replace(reference, approach=ApproachSettings(duration=seconds, start=begin)),
        run=run.replaced(duration=run.duration + seconds - before),
    )


def approach_time(experiment: Experiment) -> float | None:
    """How long the approach from the measured positions takes, in [s]; None without one.

    Raises:
        InputError: The reference is an external FMU, which begins where it begins.
    """
    seconds = experiment.hardware.approach
    if seconds is None or not experiment.hardware.use:
        return None
    if "reference" in experiment.fmus:
        what = "cannot lead an external FMU to where the hardware is: leave it out"
        raise InputError(what, file=experiment.file, key="hardware.approach")
    return seconds


def _task_position(experiment: Experiment, q: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(MusclePaths(experiment.robot).task_position(np.array(q)).tolist())


class Pace:
    """The conditions for a run by the clock, as a context; none where a run needs no clock.

    Args:
        step: Communication step, in [s].
        realtime: Whether to pace steps; those with hardware pace themselves.
        hardware: Settings of the hardware; None without.

    Attributes:
        pacer: Pacer of the master; None where it does not wait.
    """

    def __init__(
        self, step: float, realtime: bool, hardware: HardwareSettings | None = None
    ) -> None:
        self._step, self._hardware = step, hardware
        self._paces_itself = hardware is not None and hardware.goes_by_clock
        is_paced = realtime and not self._paces_itself
        self.pacer = Pacer(step) if is_paced else None
        self._conditions = ExitStack()
        self._scheduling: str | None = None

    def __enter__(self) -> Self:
        if self.pacer is not None or self._paces_itself:
            self._conditions.enter_context(without_collections())
            self._scheduling = self._conditions.enter_context(real_time_priority())
        return self

    def __exit__(self, *exception: object) -> None:
        self._conditions.close()

    def judged(self, recording: Recording) -> Recording:
        """The recording, with a failure if the hardware was lost at the end.

        Without a state for longer than the device's watchdog, the last commands may be lost.
        """
        hardware = self._hardware
        if recording.failure is not None or hardware is None or not hardware.is_paced:
            return recording
        silence = recording.columns.get("age", np.zeros(1))[-1]
        if silence <= hardware.watchdog:
            return recording
        what = f"the hardware was lost at the end: the newest state is {silence:.3g} s old"
        return replace(recording, failure=HardwareError(what))

    def report(self, recording: Recording) -> dict[str, Any]:
        """The part of the summary: empty without clock and hardware."""
        columns = recording.columns
        report: dict[str, Any] = {}
        if self._scheduling is not None:
            lateness = np.array(recording.lateness)
            if self._paces_itself:
                lateness = columns.get("lateness", np.empty(0))[1:]
            report["real_time"] = {
                **timeliness(lateness, self._step),
                "scheduling": self._scheduling,
            }
        if self._hardware is not None:
            report["hardware"] = {
                "link": self._hardware.link,
                "mode": self._hardware.mode,
                **_exchanges(columns),
            }
        return report


def _exchanges(columns: dict[str, FloatArray]) -> dict[str, Any]:
    """Statistics of the hardware's diagnostics, where they are recorded."""
    missed, trips = columns.get("missed", np.empty(0))[1:], columns.get("round_trip_time")
    if trips is None or not missed.size:
        return {"missed": None, "round_trip": None, "oldest_state": None, "unit": "s"}
    median, most = np.quantile(trips[1:], [0.5, 0.99])
    return {
        "missed": int(missed[-1]),
        "round_trip": {"median": float(median), "p99": float(most), "max": float(trips[1:].max())},
        "oldest_state": float(columns["age"][1:].max()),
        "unit": "s",
    }
