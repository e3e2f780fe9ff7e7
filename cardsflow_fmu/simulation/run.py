"""From an experiment to FMUs, and from FMUs to results."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, SimulationError
from addin_sdfusion.robot.files import write_files
from cardsflow_fmu.cosim.recording import Progress, Recording, Watch
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.fmu.description import FmiVersion
from cardsflow_fmu.fmu.platforms import libraries_for
from cardsflow_fmu.fmu.writer import write_fmu
from cardsflow_fmu.hardware.protocol.recording import RECORDING_FILE
from cardsflow_fmu.hardware.session.paced_run import Pace, with_approach
from cardsflow_fmu.native.model_file import NATIVE_MODELS, native_model
from cardsflow_fmu.results.file_names import EXPERIMENT, TABLE
from cardsflow_fmu.results.files import metadata_files, table_file
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import STARTED, Journal, no_rows
from cardsflow_fmu.results.parquet import require_parquet
from cardsflow_fmu.results.saved_run import experiment_archive
from cardsflow_fmu.results.summary import Speed, summarize
from cardsflow_fmu.runtime.library import find_platform, prebuilt_libraries, this_platform
from cardsflow_fmu.signals.muscles import modelled_muscles
from cardsflow_fmu.signals.roles import HARDWARE, ROLES
from cardsflow_fmu.ssp.from_experiment import experiment_system, with_plant
from cardsflow_fmu.ssp.writer import write_ssp
from cardsflow_fmu.utils.interrupts import ignoring_interrupts

from .participants import MODELS, PreparedFmu, Through, made_master, performer
from .result import Result

SYSTEM_FILE = "system.ssp"


class RunError(SimulationError):
    """A run that ended early.

    Args:
        message: Why.
        result: What it gave so far, marked incomplete.
    """

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


def build(
    experiment: Experiment,
    folder: str | Path,
    *,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    platforms: Sequence[str] | None = None,
    native: bool = False,
) -> dict[str, Path]:
    """Build plant.fmu, controller.fmu, reference.fmu and hardware.fmu, and system.ssp of them.

    Muscles with laws of their own have no hardware.fmu: hardware takes forces.

    Args:
        experiment: What to simulate.
        folder: Where to.
        fmi: Version of FMI of the four; the .ssp holds FMUs of FMI 2.0.
        arrays: Whether FMUs of FMI 3.0 have arrays.
        platforms: What the FMUs run on, such as `linux64`. When None, on this platform; native
            ones on all whose library came with the package. Others need the extra `cross`.
        native: Whether plant, controller and reference compute in C alone and need no Python where
            they run; hardware.fmu, which has its model in Python, is left out.

    Returns:
        The FMUs, by the name of the model; the .ssp stands beside them.

    Raises:
        InputError: The folder cannot be written, or the external FMUs do not fit.
    """
    with tempfile.TemporaryDirectory() as aside:
        libraries = _libraries(platforms, Path(aside), native)
        if fmi == "2.0" and platforms is None:
            libraries = _of_fmi_2(libraries)
        names = [name for name in _buildable(experiment) if name in NATIVE_MODELS or not native]
        files = _build(experiment, Path(aside), names, fmi, arrays, libraries, native)
        inner = files
        if fmi != "2.0":
            (Path(aside) / "inner").mkdir()
            fmi_2 = _of_fmi_2(libraries)
            inner = _build(experiment, Path(aside) / "inner", names, libraries=fmi_2, native=native)
        system = _build_system(experiment, inner, Path(aside))
        contents = {path.name: path.read_bytes() for path in (*files.values(), system)}
    written = write_files(folder, contents)
    return dict(zip(files, written[: len(files)], strict=True))


def _buildable(experiment: Experiment) -> list[str]:
    """All models, but that of the hardware where muscles are not commanded by their forces."""
    has_hardware = not modelled_muscles(experiment.robot)
    return [name for name in MODELS if name != HARDWARE or has_hardware]


def _libraries(
    platforms: Sequence[str] | None, folder: Path, native: bool
) -> dict[str, Path] | None:
    """The libraries that are asked for; all that there are when nobody asks."""
    if platforms is not None:
        return libraries_for(platforms, folder, native=native)
    if not native:
        return None
    return libraries_for([this_platform().tuple, *prebuilt_libraries()], folder, native=True)


def _of_fmi_2(libraries: Mapping[str, Path] | None) -> dict[str, Path] | None:
    """The libraries for platforms that FMI 2.0 has a name for."""
    if libraries is None:
        return None
    return {name: file for name, file in libraries.items() if find_platform(name).fmi2}


def _build(
    experiment: Experiment,
    folder: Path,
    names: Sequence[str],
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    libraries: Mapping[str, Path] | None = None,
    native: bool = False,
) -> dict[str, Path]:
    """All FMUs but external ones, by the name of the model, in a folder that exists."""
    period = experiment.controller.period
    steps = {"controller": period}
    internal = {
        "controller": period,
        "plant": experiment.plant.step,
        HARDWARE: experiment.run.step,
    }
    return {
        name: write_fmu(
            folder / f"{name}.fmu",
            model_class=MODELS[name],
            model_name=name,
            ports=MODELS[name].table(experiment),
            resources=experiment.resources(with_hardware=name == HARDWARE),
            step=steps.get(name, experiment.run.step),
            stop_time=experiment.run.duration,
            internal_step=internal.get(name),
            fmi=fmi,
            arrays=arrays,
            libraries=libraries,
            native=native_model(experiment, name) if native and name in NATIVE_MODELS else None,
        )
        for name in names
        if name not in experiment.fmus
    }


def _build_system(experiment: Experiment, fmus: Mapping[str, Path], folder: Path) -> Path:
    """The .ssp of FMI 2 FMUs with scalars, and of the external FMUs that take their place."""
    tables = {name: MODELS[name].table(experiment) for name in _buildable(experiment)}
    files = {**fmus} | {name: fmu.file for name, fmu in experiment.fmus.items()}
    system = experiment_system(experiment, files, tables)
    sources = {f"resources/{name}.fmu": file for name, file in files.items()}
    variants = {}
    if HARDWARE in files:
        variants[HARDWARE] = with_plant(system, f"resources/{HARDWARE}.fmu")
    return write_ssp(folder / SYSTEM_FILE, system, sources, variants)


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
        experiment: What to run.
        output: Folder for the results; the experiment's own when None.
        through: `fmu` for a co-simulation of FMUs, `direct` for the same loop over plain Python
            objects, `native` for the same loop in C, over models in C.
        realtime: Whether steps wait for their time by the clock, as those with hardware do anyway.
        progress: Called now and then with the number of steps done.
        watch: Called now and then with the columns' names and the rows so far.
        started: `time.perf_counter()` at the start of the program; now when None.

    Returns:
        The result, with the files that were written.

    Raises:
        HardwareError: The hardware does not answer, or is not where it is to start.
        InputError: The output folder cannot be used; nothing has been written.
        RunError: The run ended early; what it gave so far is written and marked incomplete.
    """
    started = time.perf_counter() if started is None else started
    if experiment.run.format == "parquet":
        require_parquet()
    with OutputFolder(Path(output or experiment.run.output)) as folder:
        streamed = folder.path / RECORDING_FILE if experiment.hardware.use else None
        with tempfile.TemporaryDirectory() as aside:
            driven, fmus = _prepare(experiment, Path(aside), through)
            contents: dict[str, str | bytes] = {
                path.name: path.read_bytes() for path in fmus.values()
            }
            contents[EXPERIMENT] = experiment_archive(experiment)
            there = [] if streamed is None else [streamed.name]
            with Journal(folder, contents, there) as journal:
                result, recording = _simulate(
                    driven, fmus, progress, started, realtime, streamed, watch, journal, through
                )
        with ignoring_interrupts():
            _write(result, [*contents, *there], folder)
    return _finished(result, recording)


def _prepare(
    experiment: Experiment, folder: Path, through: Through, **forms: Any
) -> tuple[Experiment, dict[str, Path]]:
    """What is run, which may have to begin elsewhere, and the FMUs that run it."""
    driven = with_approach(experiment)
    if through != "fmu":
        return driven, {}
    names = [performer(role, experiment) for role in ROLES]
    if driven is experiment:
        return driven, _build(experiment, folder, names, **forms)
    names.remove("controller")  # which is the same wherever the robot begins
    return driven, {
        **_build(driven, folder, names, **forms),
        **_build(experiment, folder, ["controller"], **forms),
    }


def _write(result: Result, written: list[str], folder: OutputFolder) -> None:
    """Write summary and figures: all of them, or none; the rest is written already."""
    contents: dict[str, str | bytes] = {}
    if result.experiment.run.format == "csv":
        written = [TABLE, *written]
    else:
        contents |= table_file(result, result.experiment.run.format)
    if len(result.rows):
        from cardsflow_fmu.report.run_figures import (
            run_images,  # matplotlib takes a second to import
        )

        contents |= run_images(result)
    there = [name for name in written if (folder.path / name).exists()]
    names = [*metadata_files(result), *contents, *there]
    result.summary["files"] = {name: name for name in names}
    result.files = folder.write(metadata_files(result) | contents, there)


def simulate(
    experiment: Experiment,
    *,
    through: Through = "fmu",
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    realtime: bool = False,
    progress: Progress | None = None,
    prepared: Mapping[str, PreparedFmu] | None = None,
) -> Result:
    """Run an experiment and write nothing. Arguments and errors as for `run` and `build`.

    Args:
        experiment: What to run.
        through: As for `run`.
        fmi: As for `build`.
        arrays: As for `build`.
        realtime: As for `run`.
        progress: As for `run`.
        prepared: FMUs that make up this experiment, by the name of the model; none is built.
    """
    started = time.perf_counter()
    if prepared is not None:
        return _finished(*_simulate(experiment, prepared, progress, started, through="fmu"))
    with tempfile.TemporaryDirectory() as folder:
        driven, fmus = _prepare(experiment, Path(folder), through, fmi=fmi, arrays=arrays)
        return _finished(*_simulate(driven, fmus, progress, started, realtime, through=through))


def _finished(result: Result, recording: Recording) -> Result:
    if recording.failure is not None:
        raise RunError(str(recording.failure), result) from recording.failure
    return result


def _simulate(
    experiment: Experiment,
    fmus: Mapping[str, Path | PreparedFmu],
    progress: Progress | None,
    started: float,
    realtime: bool = False,
    streamed: Path | None = None,
    watch: Watch | None = None,
    journal: Journal | None = None,
    through: Through = "direct",
) -> tuple[Result, Recording]:
    pace = Pace(
        experiment.run.step, realtime, experiment.hardware if experiment.hardware.use else None
    )
    if through == "native" and pace.pacer is not None:
        what = "a native loop does not wait for the clock; run it as FMUs (without --native)"
        raise InputError(what, file=experiment.file)
    with made_master(experiment, fmus, streamed, through) as master:
        if journal is not None:
            nothing = Recording(master.names, no_rows(master.names), master.units, [], [], STARTED)
            speed = Speed(0.0, time.perf_counter() - started)
            summary = summarize(experiment, nothing, speed, through)
            journal.begin(master.names, _units(nothing), master.count, summary)
        with pace:
            begin = time.perf_counter()
            recording = pace.judged(master.run(progress, pace.pacer, watch, journal))
            speed = Speed(time.perf_counter() - begin, begin - started)
    result = Result(
        recording.names,
        recording.rows,
        _units(recording),
        summarize(experiment, recording, speed, through) | pace.report(recording),
        solve_times=recording.times_of_ticks(),
        experiment=experiment,
    )
    return result, recording


def _units(recording: Recording) -> dict[str, str]:
    return {name: recording.units.get(name, "") for name in recording.names}
