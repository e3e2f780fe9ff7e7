"""Runs the system of FMUs in an .ssp file."""

from __future__ import annotations

import contextlib
import json
import tempfile
import time
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, cast

from addin_sdfusion.robot import InputError, SimulationError
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.cosim.coupling import SCHEMES, Coupling, Scheme
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.recording import Progress, Recording
from cardsflow_fmu.experiment.hardware_settings import HardwareSettings
from cardsflow_fmu.hardware.protocol.recording import RECORDING_FILE
from cardsflow_fmu.hardware.session.connect import Connection, with_link
from cardsflow_fmu.hardware.session.paced_run import Pace
from cardsflow_fmu.results.engines import system_engines
from cardsflow_fmu.results.file_names import EXPERIMENT, TABLE
from cardsflow_fmu.results.files import metadata_files
from cardsflow_fmu.results.folder import OutputFolder
from cardsflow_fmu.results.journal import STARTED, Journal, no_rows
from cardsflow_fmu.results.summary import Speed, summarize_system
from cardsflow_fmu.signals.roles import HARDWARE
from cardsflow_fmu.signals.units import conversion, variable_units
from cardsflow_fmu.simulation.result import SystemResult
from cardsflow_fmu.utils.interrupts import ignoring_interrupts

from .carried_experiment import system_experiment, system_hardware
from .reader import read_system, unpack_ssp
from .system import Component, System


class SystemRunError(SimulationError):
    """A run that ended early.

    Args:
        message: Why.
        result: What it gave so far, marked incomplete.
    """

    def __init__(self, message: str, result: SystemResult) -> None:
        super().__init__(message)
        self.result = result


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
    """Run an .ssp file and write its results: table, summary, and whose robot it is.

    Where its variant "hardware" drives hardware, every exchange is recorded beside them.

    Args:
        path: The .ssp.
        output: Folder for the results; `results` beside the file when None.
        settings: `variant`, `run.step`, `run.duration`, `run.coupling`, `run.order`, and start
            values such as `plant.q_start.elbow`.
        hardware: Address of the hardware; what the environment or the .ssp says when empty.
        realtime: Whether steps wait for their time by the clock.
        progress: Called now and then with the number of steps done.
        started: `time.perf_counter()` at the start of the program; now when None.

    Raises:
        InputError: The file cannot be run; nothing has been written.
        SystemRunError: The run ended early; what it gave so far is written and marked incomplete.
    """
    started = time.perf_counter() if started is None else started
    path = Path(path)
    carried = system_experiment(path)
    contents: dict[str, str | bytes] = {} if carried is None else {EXPERIMENT: carried}
    with OutputFolder(Path(output or path.parent / "results")) as folder:
        streamed = [RECORDING_FILE] if (settings or {}).get("variant") == HARDWARE else []
        recording = folder.path / RECORDING_FILE if streamed else None
        with (
            Connection(hardware, recording=recording).exported(),
            Journal(folder, contents, streamed) as journal,
        ):
            result = _simulate(path, settings or {}, realtime, progress, started, journal)
        with ignoring_interrupts():
            recorded = [name for name in streamed if (folder.path / name).exists()]
            there = [TABLE, *contents, *recorded]
            result.summary["files"] = {name: name for name in (*there, *metadata_files(result))}
            result.files = folder.write(metadata_files(result), there)
    if not result.complete:
        raise SystemRunError(result.summary["error"], result)
    return result


def simulate_system(
    path: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    realtime: bool = False,
    progress: Progress | None = None,
) -> SystemResult:
    """Run an .ssp file and write nothing. Arguments and errors as for `run_system`."""
    result = _simulate(Path(path), settings or {}, realtime, progress, time.perf_counter())
    if not result.complete:
        raise SystemRunError(result.summary["error"], result)
    return result


def _simulate(
    path: Path,
    settings: Mapping[str, Any],
    realtime: bool,
    progress: Progress | None,
    started: float,
    journal: Journal | None = None,
) -> SystemResult:
    runs = {k.removeprefix("run."): v for k, v in settings.items() if k.startswith("run.")}
    values = {k: v for k, v in settings.items() if not k.startswith("run.") and k != "variant"}
    with tempfile.TemporaryDirectory() as aside, _naming(path, Path(aside) / "system") as folder:
        unpack_ssp(path, folder)
        system = read_system(folder, settings.get("variant"))
        hardware = _hardware(path, settings)
        step, steps, coupling = _run_settings(Table(runs, path, "run"), system)
        parameters = _given(values, system, path)
        with _participants(system, folder, Path(aside), parameters) as participants:
            master = Master(
                participants,
                {".".join(c.target): ".".join(c.source) for c in system.connections},
                step=step,
                steps=steps,
                coupling=coupling,
                by_name=False,
                changes={".".join(c.target): c.change for c in system.connections},
            )
            about = partial(
                summarize_system,
                system.name,
                coupling=coupling.scheme,
                step=step,
                engine=system_engines({c.name: folder / c.source for c in system.components}),
            )
            units = {name: master.units.get(name, "") for name in master.names}
            if journal is not None:
                nothing = Recording(
                    master.names, no_rows(master.names), master.units, [], [], STARTED
                )
                summary = about(nothing, Speed(0.0, time.perf_counter() - started))
                journal.begin(master.names, units, master.count, summary)
            with Pace(step, realtime, hardware) as pace:
                begin = time.perf_counter()
                recording = pace.judged(master.run(progress, pace.pacer, sink=journal))
                speed = Speed(time.perf_counter() - begin, begin - started)
    summary = about(recording, speed) | pace.report(recording)
    times = recording.times_of_ticks()
    return SystemResult(recording.names, recording.rows, units, summary, solve_times=times)


def _hardware(path: Path, settings: Mapping[str, Any]) -> HardwareSettings | None:
    """The hardware that the variant of that name drives; None where it is not known."""
    known = system_hardware(path) if settings.get("variant") == HARDWARE else None
    return None if known is None else with_link(known, path, Connection.from_environment().link)


@contextlib.contextmanager
def _naming(path: Path, folder: Path) -> Iterator[Path]:
    """Errors about unpacked files name the archive that they came from."""
    try:
        yield folder
    except InputError as error:
        if error.file is not None and error.file.is_relative_to(folder):
            error.file = path / error.file.relative_to(folder)
        raise


def _run_settings(table: Table, system: System) -> tuple[float, int, Coupling]:
    """Step, number of steps and coupling."""
    for key, known in (("step", system.step), ("duration", system.stop_time)):
        if key not in table and known is None:
            raise InputError(f"does not say its {key}: give run.{key}", file=table.file)
    step = table.positive("step", system.step)
    duration = table.positive("duration", system.stop_time)
    names = [component.name for component in system.components]
    default = "sampled" if "controller" in names else "jacobi"
    scheme = cast(Scheme, table.choice("coupling", "coupling", SCHEMES, default))
    order = table.value("order", ["controller"] if scheme == "sampled" else names)
    if not isinstance(order, list) or not all(isinstance(name, str) for name in order):
        raise table.error("order", f"must be a list of names, not {json.dumps(order)}")
    table.close()
    table.multiple("duration", duration, step, "run.step")
    return step, round(duration / step), Coupling(scheme, tuple(order))


def _given(values: Mapping[str, Any], system: System, path: Path) -> dict[str, dict[str, float]]:
    """Start values from the settings by component."""
    given: dict[str, dict[str, float]] = {}
    table = Table(values, path)
    known = [component.name for component in system.components]
    for key in values:
        component, _, variable = key.partition(".")
        if component not in known or not variable:
            raise table.unknown(key, "component", component, known)
        given.setdefault(component, {})[variable] = table.number(key)
    return given


@contextlib.contextmanager
def _participants(
    system: System, folder: Path, aside: Path, given: Mapping[str, Mapping[str, float]]
) -> Iterator[list[Participant]]:
    with contextlib.ExitStack() as stack:
        participants: list[Participant] = []
        for number, component in enumerate(system.components):
            file = folder / component.source
            values = _start_values(component, file) | dict(given.get(component.name, {}))
            participant = FmuInstance(component.name, file, aside / f"fmu_{number}", values)
            stack.callback(participant.close)
            _require_connectors(component, participant, file)
            participants.append(participant)
        yield participants


def _start_values(component: Component, file: Path) -> dict[str, float]:
    """The component's parameters in the units of the FMU's variables."""
    import fmpy

    units = {}
    if any(parameter.unit for parameter in component.parameters):
        try:
            units = variable_units(fmpy.read_model_description(str(file), validate=False))
        except Exception as error:
            raise InputError(f"is no FMU: {' '.join(str(error).split())}", file=file) from None
    values = {}
    for p in component.parameters:
        values[p.name] = p.value
        if p.unit is not None and p.name in units:
            change = conversion(p.unit, units[p.name])
            values[p.name] = change.factor * p.value + change.offset
    return values


def _require_connectors(component: Component, fmu: Participant, file: Path) -> None:
    for connector in component.connectors:
        names = fmu.input_names if connector.kind == "input" else fmu.output_names
        if connector.name not in names:
            what = f"component {component.name}: the FMU has no {connector.kind}"
            raise InputError(f"{what} {connector.name!r} that is a number", file=file)
