"""Runs of experiments and of .ssp files, and their results."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from addin_sdfusion.robot import InputError, SimulationError
from addin_sdfusion.robot.json_text import finite
from cardsflow_fmu.cosim.recording import Progress, Recording, Watch
from cardsflow_fmu.hardware.session.paced_run import Pace
from cardsflow_fmu.results.files import MCAP, TABLE, Contents, metadata_files, table_file
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import STARTED, Journal, no_rows
from cardsflow_fmu.results.parquet import require_parquet
from cardsflow_fmu.results.summary import Speed
from cardsflow_fmu.ros_interface.message_types import require_ros
from cardsflow_fmu.utils.interrupts import ignoring_interrupts
from cardsflow_fmu.utils.temporary import temporary_folder

from .open_system import Opener, OpenSystem, R
from .result import Result, SystemResult

if TYPE_CHECKING:
    from cardsflow_fmu.experiment.experiment import Experiment
    from cardsflow_fmu.fmu.description import FmiVersion

    from .from_experiment import PreparedFmu, Through


class RunError(SimulationError):
    """A run that ended early.

    Args:
        message: Why.
        result: Its result so far, marked incomplete.
    """

    def __init__(self, message: str, result: SystemResult) -> None:
        super().__init__(message)
        self.result = result


def run(
    experiment: Experiment,
    output: str | Path | None = None,
    *,
    through: Through = "fmu",
    realtime: bool = False,
    progress: Progress | None = None,
    watch: Watch | None = None,
    started: float | None = None,
) -> Result:
    """Run an experiment and write its results: FMUs, table, summary and figure.

    With hardware in the place of the plant, every exchange is recorded beside them.

    Args:
        experiment: The experiment.
        output: Folder for the results; the experiment's own when None.
        through: `fmu` for a co-simulation of FMUs, native ones where the models are in C; `python`
            for FMUs with models in Python; `direct` for the same loop over plain Python objects;
            `native` for the same loop in C, over models in C.
        realtime: Whether steps wait for their time by the clock, as those with hardware do anyway.
        progress: Called now and then with the number of steps done.
        watch: Called now and then with the columns' names and the rows so far.
        started: `time.perf_counter()` at the start of the program; now when None.

    Returns:
        The result, with the files that were written.

    Raises:
        HardwareError: The hardware does not answer, or is not where it is to start.
        InputError: The output folder cannot be used; nothing has been written.
        RunError: The run ended early; its result so far is written and marked incomplete.
    """
    if experiment.run.format == "parquet":
        require_parquet()
    if experiment.run.recording == "mcap":
        require_ros("run.recording")
    opener = _experiment_opener(experiment, through, realtime)
    output = Path(output or experiment.run.output)
    return _run(opener, output, realtime=realtime, progress=progress, watch=watch, started=started)


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

    With its variant "hardware", every exchange with the hardware is recorded beside them.

    Args:
        path: The .ssp.
        output: Folder for the results; `results` beside the file when None.
        settings: `variant`, `run.step`, `run.duration`, `run.coupling`, `run.order`, and start
            values such as `plant.q_start.elbow`.
        hardware: Address of the hardware; that of the environment or the .ssp when empty.
        realtime: Whether steps wait for their time by the clock.
        progress: Called now and then with the number of steps done.
        started: `time.perf_counter()` at the start of the program; now when None.

    Raises:
        InputError: The file cannot be run; nothing has been written.
        RunError: The run ended early; its result so far is written and marked incomplete.
    """
    opener = _ssp_opener(Path(path), settings, hardware)
    output = Path(output or Path(path).parent / "results")
    return _run(opener, output, realtime=realtime, progress=progress, started=started)


def simulate(
    experiment: Experiment,
    *,
    through: Through = "fmu",
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    realtime: bool = False,
    progress: Progress | None = None,
    watch: Watch | None = None,
    prepared: Mapping[str, PreparedFmu] | None = None,
) -> Result:
    """Run an experiment and write nothing; arguments and errors as for `run` and `build`.

    With `prepared` FMUs of this experiment, by the name of the model, none is built.
    """
    options = {"fmi": fmi, "arrays": arrays, "prepared": prepared}
    opener = _experiment_opener(experiment, through, realtime, options)
    return _run(opener, None, realtime=realtime, progress=progress, watch=watch)


def simulate_system(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    realtime: bool = False,
    progress: Progress | None = None,
) -> SystemResult:
    """Run an .ssp file and write nothing. Arguments and errors as for `run_system`."""
    opener = _ssp_opener(Path(path), settings)
    return _run(opener, None, realtime=realtime, progress=progress)


def _experiment_opener(
    experiment: Experiment, through: Through, realtime: bool, options: Mapping[str, Any] = {}
) -> Opener[Result]:
    from .from_experiment import open_experiment  # with all models, which an .ssp needs not

    if through == "native" and realtime:
        what = "a native loop does not wait for the clock; run it as FMUs (without --native)"
        raise InputError(what, file=experiment.file)
    return partial(open_experiment, experiment, through, **options)


def _ssp_opener(
    path: Path, settings: Mapping[str, Any] | None, hardware: str = ""
) -> Opener[SystemResult]:
    from .from_ssp import open_ssp  # with FMPy, which takes a second

    return partial(open_ssp, path, settings or {}, hardware)


@np.errstate(over="ignore", invalid="ignore")  # what is no number is refused in every row
def _run(
    opener: Opener[R],
    output: Path | None,
    *,
    realtime: bool = False,
    progress: Progress | None = None,
    watch: Watch | None = None,
    started: float | None = None,
) -> R:
    """Open a system, run it, and write its results where there is an output folder."""
    started = time.perf_counter() if started is None else started
    with contextlib.ExitStack() as stack:
        folder = None if output is None else stack.enter_context(OutputFolder(output))
        aside = stack.enter_context(temporary_folder())
        with opener(aside, None if folder is None else folder.path) as system:
            pace = Pace(system.step, realtime, system.hardware)
            journal = None if folder is None else Journal(folder, system.contents, system.streamed)
            recording, speed = _record(system, pace, journal, started, progress, watch)
        result = system.result(
            recording.names,
            recording.rows,
            recording.units,
            finite(system.summarize(recording, speed) | pace.report(recording)),
            solve_times=recording.times_of_ticks(),
        )
        if folder is not None:
            with ignoring_interrupts():
                _write(result, [*system.contents, *system.streamed], folder)
    if recording.failure is not None:
        raise RunError(str(recording.failure), result) from recording.failure
    return result


def _record(
    system: OpenSystem[R],
    pace: Pace,
    journal: Journal | None,
    started: float,
    progress: Progress | None = None,
    watch: Watch | None = None,
) -> tuple[Recording, Speed]:
    """Step an open system to its end, under the journal where there is one."""
    loop = system.loop
    with contextlib.nullcontext() if journal is None else journal:
        if journal is not None:
            nothing = Recording(loop.names, no_rows(loop.names), loop.units, [], [], STARTED)
            summary = system.summarize(nothing, Speed(0.0, time.perf_counter() - started))
            journal.begin(loop.names, loop.units, loop.count, summary)
        with pace:
            begin = time.perf_counter()
            recording = pace.judged(loop.run(progress, pace.pacer, watch, journal))
            speed = Speed(time.perf_counter() - begin, begin - started)
    return recording, speed


def _write(result: SystemResult, written: list[str], folder: OutputFolder) -> None:
    """Write summary and figures: all of them, or none; the rest is written already."""
    contents: Contents = {}
    form = result.experiment.run.format if isinstance(result, Result) else "csv"
    if form == "csv":
        written = [TABLE, *written]
    else:
        contents |= table_file(result, form)
    if isinstance(result, Result) and len(result.rows):
        from cardsflow_fmu.report.run_figures import run_images  # matplotlib takes a second

        contents |= run_images(result)
        if result.experiment.run.recording == "mcap":
            from cardsflow_fmu.ros.recording import write_recording

            write_recording(result, folder.path / MCAP)
            written = [*written, MCAP]
    there = [name for name in written if (folder.path / name).exists()]
    names = [*metadata_files(result), *contents, *there]
    result.summary["files"] = {name: name for name in names}
    result.files = folder.write(metadata_files(result) | contents, there)
