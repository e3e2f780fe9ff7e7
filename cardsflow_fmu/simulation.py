"""From an experiment to FMUs, and from FMUs to results."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from addin_sdfusion.robot import SimulationError
from addin_sdfusion.robot.files import write_files

from .experiment import Experiment
from .fmu_file import write_fmu
from .fmu_instance import FmuInstance
from .master import Master, Progress, Recording, ignoring_interrupts
from .models.controller import ControllerModel
from .models.experiment_model import ExperimentModel
from .models.plant import PlantModel
from .models.reference import ReferenceModel
from .output import OutputFolder
from .participants import DirectParticipant, Participant
from .results import Result, summarize

Through = Literal["fmu", "direct"]

MODELS: dict[str, type[ExperimentModel]] = {
    "plant": PlantModel,
    "controller": ControllerModel,
    "reference": ReferenceModel,
}


class RunError(SimulationError):
    """A run that ended early.

    Args:
        message: Why.
        result: What it gave so far, marked incomplete.
    """

    def __init__(self, message: str, result: Result) -> None:
        super().__init__(message)
        self.result = result


def build(experiment: Experiment, folder: str | Path) -> dict[str, Path]:
    """Build plant.fmu, controller.fmu and reference.fmu.

    Args:
        experiment: What to simulate.
        folder: Where to.

    Returns:
        The files, by the name of the model.

    Raises:
        InputError: The folder cannot be written.
    """
    with tempfile.TemporaryDirectory() as aside:
        files = _build(experiment, Path(aside))
        contents = {path.name: path.read_bytes() for path in files.values()}
    return dict(zip(files, write_files(folder, contents), strict=True))


def _build(experiment: Experiment, folder: Path) -> dict[str, Path]:
    """The FMUs, by the name of the model, in a folder that exists."""
    resources = experiment.resources()
    steps = {"controller": experiment.controller.period}
    return {
        name: write_fmu(
            folder / f"{name}.fmu",
            model_class=model,
            model_name=name,
            ports=model.table(experiment),
            resources=resources,
            step=steps.get(name, experiment.run.step),
            stop_time=experiment.run.duration,
        )
        for name, model in MODELS.items()
    }


def run(
    experiment: Experiment,
    output: str | Path | None = None,
    *,
    through: Through = "fmu",
    progress: Progress | None = None,
    started: float | None = None,
) -> Result:
    """Run an experiment and write its results: FMUs, table, summary and figure.

    Args:
        experiment: What to run.
        output: Folder for the results; the experiment's own when None.
        through: `fmu` for a co-simulation of FMUs, `direct` for the same loop over plain Python
            objects.
        progress: Called now and then with the number of steps done.
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
            result, recording = _simulate(experiment, fmus, progress, started)
            contents: dict[str, str | bytes] = {
                path.name: path.read_bytes() for path in fmus.values()
            }
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
    experiment: Experiment, *, through: Through = "fmu", progress: Progress | None = None
) -> Result:
    """Run an experiment and write nothing. Arguments and errors as for `run`."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        fmus = _build(experiment, Path(folder)) if through == "fmu" else {}
        return _finished(*_simulate(experiment, fmus, progress, started))


def _finished(result: Result, recording: Recording) -> Result:
    if recording.failure is not None:
        raise RunError(str(recording.failure), result) from recording.failure
    return result


def _simulate(
    experiment: Experiment, fmus: dict[str, Path], progress: Progress | None, started: float
) -> tuple[Result, Recording]:
    with _participants(experiment, fmus) as participants:
        settings = experiment.run
        master = Master(
            **participants,
            wiring=experiment.wiring,
            step=settings.step,
            steps=settings.steps,
            ticks_every=round(experiment.controller.period / settings.step),
        )
        begin = time.perf_counter()
        recording = master.run(progress)
        wall_time = time.perf_counter() - begin
    units = {port.name: port.unit for model in MODELS.values() for port in model.table(experiment)}
    result = Result(
        experiment,
        recording.names,
        recording.rows,
        {name: "s" if name == "time" else units.get(name, "") for name in recording.names},
        summarize(experiment, recording, wall_time, begin - started),
    )
    return result, recording


@contextlib.contextmanager
def _participants(
    experiment: Experiment, fmus: dict[str, Path]
) -> Iterator[dict[str, Participant]]:
    """The participants by name: an FMU where there is one, else the model itself."""
    with contextlib.ExitStack() as stack:
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        participants: dict[str, Participant] = {}
        for name, model in MODELS.items():
            participants[name] = (
                FmuInstance(name, fmus[name], unpacked / name)
                if name in fmus
                else DirectParticipant(name, model(experiment))
            )
            stack.callback(participants[name].close)
        yield participants
