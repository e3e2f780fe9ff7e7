"""From an experiment to FMUs, and from FMUs to results."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.files import write_files

from .cross import libraries_for
from .experiment import Experiment
from .experiment_system import experiment_system, with_plant
from .fmu_file import write_fmu
from .fmu_instance import FmuInstance
from .foreign_fmu import HARDWARE, AdaptedFmu, fitting_wiring
from .interruption import ignoring_interrupts
from .master import Master, Progress, Recording, Watch
from .model_description import FmiVersion
from .models.controller import ControllerModel
from .models.experiment_model import ExperimentModel
from .models.plant import PlantModel
from .models.reference import ReferenceModel
from .output import OutputFolder
from .participants import DirectParticipant, Participant
from .ports import load_signals
from .results import Result
from .runtime.library import find_platform
from .saved_run import EXPERIMENT, experiment_archive
from .ssp import write_ssp
from .summary import Speed, summarize

Through = Literal["fmu", "direct"]

SYSTEM_FILE = "system.ssp"

MODELS: dict[str, type[ExperimentModel]] = {
    "plant": PlantModel,
    "controller": ControllerModel,
    "reference": ReferenceModel,
}


class PreparedFmu(NamedTuple):
    """An FMU that stands ready for several runs.

    Attributes:
        file: The .fmu.
        folder: Where it is unpacked, or empty.
        start_values: Values of its parameters, by name; its own where left out.
    """

    file: Path
    folder: Path
    start_values: Mapping[str, float] = {}


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
) -> dict[str, Path]:
    """Build plant.fmu, controller.fmu and reference.fmu, and system.ssp of the three.

    Args:
        experiment: What to simulate.
        folder: Where to.
        fmi: Version of FMI of the three; the .ssp holds FMUs of FMI 2.0.
        arrays: Whether FMUs of FMI 3.0 have arrays.
        platforms: What the FMUs run on, such as `linux64`; on this platform when None. Others need
            the extra `cross`.

    Returns:
        The FMUs, by the name of the model; the .ssp stands beside them.

    Raises:
        InputError: The folder cannot be written, or the FMUs of others do not fit.
    """
    with tempfile.TemporaryDirectory() as aside:
        libraries = None if platforms is None else libraries_for(platforms, Path(aside))
        files = _build(experiment, Path(aside), fmi, arrays, libraries)
        inner = files
        if fmi != "2.0":
            (Path(aside) / "inner").mkdir()
            inner = _build(experiment, Path(aside) / "inner", libraries=_of_fmi_2(libraries))
        system = _build_system(experiment, inner, Path(aside))
        contents = {path.name: path.read_bytes() for path in (*files.values(), system)}
    written = write_files(folder, contents)
    return dict(zip(files, written[: len(files)], strict=True))


def _of_fmi_2(libraries: Mapping[str, Path] | None) -> dict[str, Path] | None:
    """The libraries for platforms that FMI 2.0 has a name for."""
    if libraries is None:
        return None
    return {name: file for name, file in libraries.items() if find_platform(name).fmi2}


def _build(
    experiment: Experiment,
    folder: Path,
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    libraries: Mapping[str, Path] | None = None,
) -> dict[str, Path]:
    """The FMUs that are not of others, by the name of the model, in a folder that exists."""
    resources = experiment.resources()
    period = experiment.controller.period
    steps = {"controller": period}
    internal = {"controller": period, "plant": experiment.plant.step}
    return {
        name: write_fmu(
            folder / f"{name}.fmu",
            model_class=model,
            model_name=name,
            ports=model.table(experiment),
            resources=resources,
            step=steps.get(name, experiment.run.step),
            stop_time=experiment.run.duration,
            internal_step=internal.get(name),
            fmi=fmi,
            arrays=arrays,
            libraries=libraries,
        )
        for name, model in MODELS.items()
        if name not in experiment.fmus
    }


def _build_system(experiment: Experiment, fmus: Mapping[str, Path], folder: Path) -> Path:
    """The .ssp of FMI 2 FMUs with scalars, and of the FMUs of others that take their place."""
    tables = {name: model.table(experiment) for name, model in MODELS.items()}
    files = {**fmus} | {name: fmu.file for name, fmu in experiment.fmus.items()}
    system = experiment_system(experiment, files, tables)
    sources = {f"resources/{name}.fmu": file for name, file in files.items()}
    variants = {}
    if HARDWARE in experiment.fmus:
        variants[HARDWARE] = with_plant(system, f"resources/{HARDWARE}.fmu")
    return write_ssp(folder / SYSTEM_FILE, system, sources, variants)


def run(
    experiment: Experiment,
    output: str | Path | None = None,
    *,
    through: Through = "fmu",
    progress: Progress | None = None,
    watch: Watch | None = None,
    started: float | None = None,
) -> Result:
    """Run an experiment and write its results: FMUs, table, summary and figure.

    Args:
        experiment: What to run.
        output: Folder for the results; the experiment's own when None.
        through: `fmu` for a co-simulation of FMUs, `direct` for the same loop over plain Python
            objects.
        progress: Called now and then with the number of steps done.
        watch: Called now and then with the columns' names and the rows so far.
        started: `time.perf_counter()` at the start of the program; now when None.

    Returns:
        The result, with the files that were written.

    Raises:
        InputError: The output folder cannot be used; nothing has been written.
        RunError: The run ended early; what it gave so far is written and marked incomplete.
    """
    started = time.perf_counter() if started is None else started
    with OutputFolder(Path(output or experiment.run.output)) as folder:
        with tempfile.TemporaryDirectory() as aside:
            fmus = _build(experiment, Path(aside)) if through == "fmu" else {}
            contents: dict[str, str | bytes] = {
                path.name: path.read_bytes() for path in fmus.values()
            }
            contents[EXPERIMENT] = experiment_archive(experiment)
            result, recording = _simulate(experiment, fmus, progress, started, watch)
        with ignoring_interrupts():
            _write(result, contents, folder)
    return _finished(result, recording)


def _write(result: Result, contents: dict[str, str | bytes], folder: OutputFolder) -> None:
    """Write table, summary, figure and FMUs: all of them, or none."""
    if len(result.rows):
        from .plots import run_images  # matplotlib takes a second to import

        contents |= run_images(result)
    names = [*result.contents(), *contents]
    result.summary["files"] = {name: name for name in names}
    result.files = folder.write(contents | result.contents())


def simulate(
    experiment: Experiment,
    *,
    through: Through = "fmu",
    fmi: FmiVersion = "2.0",
    arrays: bool = True,
    progress: Progress | None = None,
    prepared: Mapping[str, PreparedFmu] | None = None,
) -> Result:
    """Run an experiment and write nothing. Arguments and errors as for `run` and `build`.

    Args:
        experiment: What to run.
        through: As for `run`.
        fmi: As for `build`.
        arrays: As for `build`.
        progress: As for `run`.
        prepared: FMUs that make up this experiment, by the name of the model; none is built.
    """
    started = time.perf_counter()
    if prepared is not None:
        return _finished(*_simulate(experiment, prepared, progress, started))
    with tempfile.TemporaryDirectory() as folder:
        fmus = _build(experiment, Path(folder), fmi, arrays) if through == "fmu" else {}
        return _finished(*_simulate(experiment, fmus, progress, started))


def _finished(result: Result, recording: Recording) -> Result:
    if recording.failure is not None:
        raise RunError(str(recording.failure), result) from recording.failure
    return result


def _simulate(
    experiment: Experiment,
    fmus: Mapping[str, Path | PreparedFmu],
    progress: Progress | None,
    started: float,
    watch: Watch | None = None,
) -> tuple[Result, Recording]:
    with _participants(experiment, fmus) as participants:
        settings = experiment.run
        master = Master(
            [participants[name] for name in ("plant", "reference", "controller")],
            fitting_wiring(
                experiment.wiring,
                experiment.fmus,
                participants.values(),
                load_signals(experiment.robot),
            ),
            step=settings.step,
            steps=settings.steps,
            coupling=settings.coupling,
            every={"controller": round(experiment.controller.period / settings.step)},
        )
        begin = time.perf_counter()
        recording = master.run(progress, watch)
        speed = Speed(time.perf_counter() - begin, begin - started)
    result = Result(
        recording.names,
        recording.rows,
        {name: recording.units.get(name, "") for name in recording.names},
        summarize(experiment, recording, speed),
        experiment=experiment,
    )
    return result, recording


@contextlib.contextmanager
def _participants(
    experiment: Experiment, fmus: Mapping[str, Path | PreparedFmu]
) -> Iterator[dict[str, Participant]]:
    """The participants by name: an FMU where there is one, else the model itself."""
    with contextlib.ExitStack() as stack:
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        participants: dict[str, Participant] = {}
        for name, model in MODELS.items():
            foreign = experiment.fmus.get(name)
            participant: Participant
            if foreign is not None:
                participant = FmuInstance(name, foreign.file, unpacked / name, foreign.parameters)
                stack.callback(participant.close)
                participant = AdaptedFmu(participant, foreign, model.table(experiment))
            elif name in fmus:
                own = fmus[name]
                ready = own if isinstance(own, PreparedFmu) else PreparedFmu(own, unpacked / name)
                participant = FmuInstance(name, *ready)
                stack.callback(participant.close)
            else:
                participant = DirectParticipant(name, model(experiment))
            participants[name] = participant
        yield participants
