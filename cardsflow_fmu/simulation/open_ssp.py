"""Initialised and connected FMUs of an .ssp file."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.fmu_description import read_description
from cardsflow_fmu.cosim.fmu_instance import FmuInstance
from cardsflow_fmu.cosim.master import Master
from cardsflow_fmu.cosim.participant import Participant
from cardsflow_fmu.cosim.recording import Recording
from cardsflow_fmu.cosim.signals.roles import HARDWARE
from cardsflow_fmu.cosim.signals.units import conversion, variable_units
from cardsflow_fmu.cosim.wiring import members
from cardsflow_fmu.experiment.config.multiples import require_multiple
from cardsflow_fmu.experiment.config.table import Context, validated
from cardsflow_fmu.experiment.settings.hardware import HardwareSettings
from cardsflow_fmu.experiment.settings.run import Accept
from cardsflow_fmu.results.engines import system_engines
from cardsflow_fmu.results.files import EXPERIMENT, RECORDING_FILE
from cardsflow_fmu.results.summary import Speed, summarize_system
from cardsflow_fmu.simulation.ssp.packed_experiment import system_experiment, system_hardware
from cardsflow_fmu.simulation.ssp.reader import name_archive_in_errors, read_system, unpack_ssp
from cardsflow_fmu.simulation.ssp.settings import SystemRunSettings
from cardsflow_fmu.simulation.ssp.system import Component, System

from .open_system import OpenSystem
from .result import SystemResult


@dataclass(frozen=True, kw_only=True)
class OpenSsp(OpenSystem[SystemResult]):
    """Initialised FMUs of an .ssp file."""

    name: str
    scheme: str
    accept: Accept
    engine: Mapping[str, str]

    def summary(self, recording: Recording, speed: Speed) -> dict[str, Any]:
        """Return the summary of a recording."""
        return summarize_system(
            self.name,
            recording,
            speed,
            scheme=self.scheme,
            step=self.step,
            engine=self.engine,
            accept=self.accept,
        )

    def result(self, recording: Recording, summary: dict[str, Any]) -> SystemResult:
        """Return the result of a recording."""
        return SystemResult(
            recording.names,
            recording.rows,
            recording.units,
            summary,
            solve_times=recording.times_of_ticks(),
        )


@contextlib.contextmanager
def open_ssp(
    path: Path, settings: Mapping[str, Any], hardware: str, scratch: Path, folder: Path
) -> Iterator[OpenSsp]:
    """Start and connect the FMUs of an .ssp file.

    Raises:
        InputError: The file cannot be run.
        SimulationError: An FMU does not start.
    """
    runs = {k.removeprefix("run."): v for k, v in settings.items() if k.startswith("run.")}
    values = {k: v for k, v in settings.items() if not k.startswith("run.") and k != "variant"}
    variant = settings.get("variant")
    carried = system_experiment(path)
    streamed = [RECORDING_FILE] if variant == HARDWARE else []
    recording = folder / RECORDING_FILE if streamed else None
    with (
        _hardware_address(hardware, recording),
        name_archive_in_errors(path, scratch / "system") as unpacked,
    ):
        unpack_ssp(path, unpacked)
        system = read_system(unpacked, variant)
        driven = _hardware(path) if variant == HARDWARE else None
        run, coupling = _run_settings(runs, system, path)
        parameters = _start_value_settings(values, system, path)
        files = {c.name: unpacked / c.source for c in system.components}
        with _participants(system, files, scratch, parameters) as participants:
            loop = Master(
                participants,
                {".".join(c.target): ".".join(c.source) for c in system.connections},
                step=run.step,
                steps=round(run.duration / run.step),
                coupling=coupling,
                by_name=False,
                changes={".".join(c.target): c.change for c in system.connections},
            )
            yield OpenSsp(
                name=system.name,
                loop=loop,
                step=run.step,
                scheme=coupling.scheme,
                accept=run.accept,
                engine=system_engines(files),
                hardware=driven,
                contents={} if carried is None else {EXPERIMENT: carried},
                streamed=streamed,
            )


@contextlib.contextmanager
def _hardware_address(hardware: str, recording: Path | None) -> Iterator[None]:
    """Provide the address of the hardware to FMUs that are started in the context."""
    if not hardware and recording is None:
        yield
        return
    from cardsflow_fmu.hardware.session.connect import Connection

    with Connection(hardware, recording=recording).exported():
        yield


def _hardware(path: Path) -> HardwareSettings | None:
    """Return the hardware of the variant "hardware"; None if unknown."""
    from cardsflow_fmu.hardware.session.connect import Connection, with_link

    device = system_hardware(path)
    return None if device is None else with_link(device, path, Connection.from_environment().link)


def _run_settings(
    settings: Mapping[str, Any], system: System, path: Path
) -> tuple[SystemRunSettings, Coupling]:
    """Return the settings of the run, and the coupling."""
    for key, value in (("step", system.step), ("duration", system.stop_time)):
        if key not in settings and value is None:
            raise InputError(f"does not specify its {key}; set run.{key}", file=path)
    names = tuple(component.name for component in system.components)
    usual = {
        "step": system.step,
        "duration": system.stop_time,
        "scheme": "sampled" if "controller" in names else "jacobi",
    }
    run = SystemRunSettings.read(usual | dict(settings), Context(path), "run")
    require_multiple(run.duration, run.step, "run.step", file=path, key="run.duration")
    order = ("controller",) if run.scheme == "sampled" else names
    coupling = Coupling(run.scheme, order if run.order is None else run.order)
    return run, coupling


def _start_value_settings(
    values: Mapping[str, Any], system: System, path: Path
) -> dict[str, dict[str, float]]:
    """Return the start values in the settings, by component."""
    values_of: dict[str, dict[str, float]] = {}
    names = [component.name for component in system.components]
    for key, value in values.items():
        component, _, variable = key.partition(".")
        if component not in names or not variable:
            raise UnknownNameError("component", component, names, file=path, key=key)
        values_of.setdefault(component, {})[variable] = validated(float, value, key, path)
    return values_of


@contextlib.contextmanager
def _participants(
    system: System,
    files: Mapping[str, Path],
    scratch: Path,
    values_of: Mapping[str, Mapping[str, float]],
) -> Iterator[list[Participant]]:
    with contextlib.ExitStack() as stack:
        participants: list[Participant] = []
        for number, component in enumerate(system.components):
            file = files[component.name]
            values, start_values = _start_values(component, file), values_of.get(component.name, {})
            replaced = {name for group in start_values for name in members(group, values)}
            values = {n: v for n, v in values.items() if n not in replaced} | dict(start_values)
            participant = FmuInstance(component.name, file, scratch / f"fmu_{number}", values)
            stack.callback(participant.close)
            _require_connectors(component, participant, file)
            participants.append(participant)
        yield participants


def _start_values(component: Component, file: Path) -> dict[str, float]:
    """Return the parameters of a component in the units of the FMU."""
    units = {}
    if any(parameter.unit for parameter in component.parameters):
        units = variable_units(read_description(file))
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
            problem = f"component {component.name}: the FMU has no numeric {connector.kind}"
            raise InputError(f"{problem} {connector.name!r}", file=file)
