"""Runs of experiments and of .ssp files, and their results."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.json_text import finite
from cardsflow_fmu.cosim.pace import Pace
from cardsflow_fmu.cosim.recording import Progress, Recording, Watch
from cardsflow_fmu.experiment.settings.run import Compute, ModelCoupling, RunSettings
from cardsflow_fmu.results.estimation import updated_calibration
from cardsflow_fmu.results.files import MCAP, NPY, Contents, metadata_files
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import STARTED, Journal
from cardsflow_fmu.results.summary import Speed
from cardsflow_fmu.utils.interrupts import ignore_interrupts
from cardsflow_fmu.utils.temporary import temporary_folder

from .open_system import OpenSystem, R
from .result import Result, SystemResult

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.fmu.description import FmiVersion


class RunError(SimulationError):
    """Error of a run that ended early."""

    def __init__(self, message: str, result: SystemResult) -> None:
        super().__init__(message)
        self.result = result


def run(
    experiment: Experiment,
    output: str | Path | None = None,
    *,
    compute: Compute | None = None,
    coupling: ModelCoupling | None = None,
    realtime: bool = False,
    progress: Progress | None = None,
    watch: Watch | None = None,
    started: float | None = None,
) -> Result:
    """Run an experiment and write its results: FMUs, table and summary.

    If `run.figures` is true, figures are drawn. With hardware instead of the plant, every exchange
    is recorded in the same folder.

    Args:
        output: Results folder (default: `run.output` of the experiment).
        compute: `c` for models in C where possible, `python` for models that a Python process
            hosts (default: `run.compute` of the experiment).
        coupling: `fmu` for a co-simulation of FMUs; `direct` for models without FMUs
            (default: `run.coupling` of the experiment).
        realtime: Whether to run in real time. Runs with hardware are always in real time.
        progress: Called regularly with the number of completed steps.
        watch: Called regularly with the column names and the rows so far.
        started: `time.perf_counter()` at the start of the program (default: current time).

    Returns:
        The result, with the files that were written.

    Raises:
        HardwareError: The hardware does not answer, or is not at the start pose.
        InputError: The output folder cannot be used. No file is written.
        RunError: The run ended early; its result so far is written and marked incomplete.
    """
    from .open import open_experiment  # imports all models, which an .ssp does not need

    if experiment.run.recording == "mcap":
        from cardsflow_fmu.ros_interface.message_types import require_ros

        require_ros("run.recording")
    experiment = _with_settings(experiment, compute, coupling)
    with _folders(output or experiment.run.output) as (folder, scratch):
        opening = open_experiment(experiment, scratch, folder.path)
        return _run(opening, folder, realtime, progress, watch, started)


def run_system(
    path: str | Path,
    output: str | Path | None = None,
    settings: Mapping[str, Any] | None = None,
    *,
    hardware: str = "",
    realtime: bool = False,
    progress: Progress | None = None,
    started: float | None = None,
) -> SystemResult:
    """Run an .ssp file and write its results: table, summary, and the experiment in its FMUs.

    With the variant "hardware", every exchange with the hardware is recorded in the same folder.

    Args:
        path: The .ssp file.
        output: Results folder (default: `results` in the folder of the file).
        settings: `variant`, `run.step`, `run.duration`, `run.scheme`, `run.order`, and start
            values such as `plant.q_start.elbow`.
        hardware: Address of the hardware (default: from the environment or the .ssp).
        realtime: Whether to run in real time.
        progress: Called regularly with the number of completed steps.
        started: `time.perf_counter()` at the start of the program (default: current time).

    Raises:
        InputError: The file cannot be run. No file is written.
        RunError: The run ended early; its result so far is written and marked incomplete.
    """
    from .open_ssp import open_ssp  # imports FMPy, which takes a second

    with _folders(output or Path(path).parent / "results") as (folder, scratch):
        opening = open_ssp(Path(path), settings or {}, hardware, scratch, folder.path)
        return _run(opening, folder, realtime, progress, started=started)


def simulate(
    experiment: Experiment,
    *,
    compute: Compute | None = None,
    coupling: ModelCoupling | None = None,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    realtime: bool = False,
    progress: Progress | None = None,
    watch: Watch | None = None,
) -> Result:
    """Run an experiment and write nothing; arguments and errors as for `run` and `build`."""
    from .open import open_experiment

    experiment = _with_settings(experiment, compute, coupling)
    with temporary_folder() as scratch:
        opening = open_experiment(experiment, scratch, None, fmi=fmi, arrays=arrays)
        return _run(opening, None, realtime, progress, watch)


def _with_settings(
    experiment: Experiment,
    compute: Compute | None,
    coupling: ModelCoupling | None,
) -> Experiment:
    run_settings = experiment.run
    compute, coupling = compute or run_settings.compute, coupling or run_settings.coupling
    RunSettings(compute=compute, coupling=coupling)  # checks the values
    return replace(experiment, run=run_settings.copy_with(compute=compute, coupling=coupling))


@contextlib.contextmanager
def _folders(output: str | Path) -> Iterator[tuple[OutputFolder, Path]]:
    """Lock the results folder, and create a temporary folder."""
    with OutputFolder(Path(output)) as folder, temporary_folder() as scratch:
        yield folder, scratch


@np.errstate(
    over="ignore", invalid="ignore"
)  # a check of every row reports values that are not finite
def _run(
    opening: AbstractContextManager[OpenSystem[R]],
    folder: OutputFolder | None,
    realtime: bool,
    progress: Progress | None = None,
    watch: Watch | None = None,
    started: float | None = None,
) -> R:
    """Open a system, run it, and write its results if there is a folder."""
    started = time.perf_counter() if started is None else started
    with opening as system:
        loop, pace = system.loop, _pace(system, realtime)
        journal = (
            None
            if folder is None
            else Journal(folder, system.contents, system.streamed, system.table_format)
        )
        with contextlib.nullcontext() if journal is None else journal:
            if journal is not None:
                empty = Recording(
                    loop.names,
                    np.empty((0, len(loop.names))),
                    loop.units,
                    np.arange(0),
                    np.empty(0),
                    STARTED,
                )
                summary = system.summary(empty, Speed(0.0, time.perf_counter() - started))
                journal.begin(loop.names, loop.units, loop.count, summary)
            with pace:
                begin = time.perf_counter()
                recording = pace.with_final_check(loop.run(progress, pace.pacer, watch, journal))
                speed = Speed(time.perf_counter() - begin, begin - started)
    summary, report = system.summary(recording, speed), pace.report(recording)
    if "hardware" in report:
        report["hardware"] |= summary.get("hardware", {})
    result = system.result(recording, finite(summary | report))
    if folder is not None:
        with ignore_interrupts():
            assert journal is not None
            written = [journal.table, *system.contents, *system.streamed]
            _write(result, written, folder, is_large=journal.table == NPY)
    if recording.failure is not None:
        raise RunError(str(recording.failure), result) from recording.failure
    return result


def _pace(system: OpenSystem[R], realtime: bool) -> Pace:
    if system.hardware is None:
        return Pace(system.step, realtime)
    from cardsflow_fmu.hardware.session.paced_run import HardwarePace

    return HardwarePace(system.step, realtime, system.hardware)


def _write(
    result: SystemResult, written: list[str], folder: OutputFolder, *, is_large: bool
) -> None:
    """Write summary and figures: all files, or none on an error."""
    contents: Contents = {}
    if isinstance(result, Result) and len(result.rows):
        contents |= updated_calibration(result.experiment, result.summary)
        if result.experiment.run.figures:
            from cardsflow_fmu.results.report.run_figures import run_images  # imports matplotlib

            contents |= run_images(result)
        if result.experiment.run.recording == "mcap":
            from cardsflow_fmu.ros.recording import write_recording

            write_recording(result, folder.path / MCAP)
            written = [*written, MCAP]
    existing = [name for name in written if (folder.path / name).exists()]
    names = [*metadata_files(result, is_large=is_large), *contents, *existing]
    result.summary["files"] = {name: name for name in names}
    result.files = folder.write(metadata_files(result, is_large=is_large) | contents, existing)
