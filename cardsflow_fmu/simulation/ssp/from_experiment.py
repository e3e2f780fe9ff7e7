"""Conversion of experiments to systems of FMUs for .ssp files."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.external_fmu import (
    ExternalFmu,
    experiment_names,
    specified_units,
    without_missing_loads,
)
from cardsflow_fmu.cosim.signals.ports import Port, external_load_signals
from cardsflow_fmu.cosim.signals.roles import ROLES
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Unit, conversion, variable_units
from cardsflow_fmu.cosim.wiring import routes
from cardsflow_fmu.experiment.experiment import Experiment

from .system import Component, Connection, Connector, Parameter, System

_TYPES = {"Real": "Real", "Float64": "Real", "Boolean": "Boolean"}


def experiment_system(
    experiment: Experiment, fmus: Mapping[str, Path], tables: Mapping[str, Sequence[Port]]
) -> System:
    """Return reference, controller and plant, connected as in a run of the experiment.

    Raises:
        InputError: The participants do not match, or SSP does not support a connector.
    """
    order = ("reference", *experiment.roles[len(ROLES) :], "controller", "plant")
    parts = [_Part(role, fmus[role], experiment.fmus.get(role), tables[role]) for role in order]
    by_role = {part.name: part for part in parts}
    connections: list[Connection] = []
    loads = external_load_signals(experiment.robot, experiment.plant.wrenches)
    wiring = without_missing_loads(experiment.wiring, experiment.fmus, parts, loads)
    for target, source in routes(parts, wiring).items():
        role, input_ = target.split(".", 1)
        if isinstance(source, str):
            giver, output = source.split(".", 1)
            connections.append(_connection(by_role[giver], output, by_role[role], input_))
        elif source != 0.0:
            by_role[role].set_start_value(input_, source)
    return System(
        experiment.name,
        tuple(part.component({c.target for c in connections}) for part in parts),
        tuple(connections),
        # other importers use one step for all FMUs, which must be the controller period
        experiment.controller.period,
        experiment.run.duration,
    )


def replace_plant(system: System, source: str) -> System:
    """Return the system with another FMU as plant, such as the hardware FMU."""
    components = tuple(
        replace(c, source=source, parameters=()) if c.name == "plant" else c
        for c in system.components
    )
    return replace(system, components=components)


def _connection(source: _Part, output: str, target: _Part, input_: str) -> Connection:
    route = f"{source.name}.{output} -> {target.name}.{input_}"
    try:
        change = conversion(source.unit("output", output), target.unit("input", input_))
    except InputError as error:
        raise InputError(f"{route}: {error.problem}", key="wiring") from None
    ends = (
        (source.name, source.variable("output", output)),
        (target.name, target.variable("input", input_)),
    )
    return Connection(*ends, change)


class _Part:
    """FMU of the system with the names of the experiment."""

    def __init__(
        self, role: str, file: Path, external: ExternalFmu | None, ports: Sequence[Port]
    ) -> None:
        from cardsflow_fmu.cosim.fmu_description import read_description  # takes a second

        self.name = role
        self._file = file
        try:
            description = read_description(file)
        except Exception as error:  # damaged files raise errors of any type
            raise InputError(f"is not an FMU: {' '.join(str(error).split())}", file=file) from None
        self._variables = {v.name: v for v in description.modelVariables}
        self._units: dict[str, Unit] = variable_units(description)
        self._start_values: list[Parameter] = []
        self._variable_of: dict[str, dict[str, str]] = {"input": {}, "output": {}}
        self._parameters = [] if external else [p for p in ports if p.causality == "parameter"]
        names = {side: self._side(side) for side in self._variable_of}
        if external is not None:
            self._units |= specified_units(external, [*names["input"], *names["output"]])
            self._start_values = [Parameter(*entry) for entry in external.parameters.items()]
            for side in self._variable_of:
                table = experiment_names(external, side, names[side], ports)
                self._variable_of[side] = {port: variable for variable, port in table.items()}
        for side, back in self._variable_of.items():
            back |= {name: name for name in names[side] if name not in back.values()}
        self.input_names = tuple(self._variable_of["input"])
        self.output_names = tuple(self._variable_of["output"])

    def variable(self, side: str, port: str) -> str:
        """Return the variable of the FMU for a port."""
        return self._variable_of[side][port]

    def unit(self, side: str, port: str) -> Unit | None:
        """Return the unit of the variable of a port."""
        return self._units.get(self.variable(side, port))

    def set_start_value(self, port: str, value: float) -> None:
        """Set the start value of an input."""
        self._start_values.append(Parameter(self.variable("input", port), value))

    def component(self, connected: Collection[tuple[str, str]]) -> Component:
        """Return the FMU as a component of a system.

        Args:
            connected: Connected inputs. Other inputs have no connectors; FMPy would connect them.
        """
        inputs = [name for name in self._side("input") if (self.name, name) in connected]
        connectors = [
            *(self._connector(name, "input") for name in inputs),
            *(self._connector(name, "output") for name in self._side("output")),
        ]
        parameters = [Parameter(p.name, p.start, KNOWN_UNITS.get(p.unit)) for p in self._parameters]
        source = f"resources/{self.name}.fmu"
        return Component(self.name, source, tuple(connectors), (*parameters, *self._start_values))

    def _connector(self, name: str, kind: Literal["input", "output"]) -> Connector:
        kind_of_value = _TYPES[self._variables[name].type]
        unit = self._units.get(name) if kind_of_value == "Real" else None
        return Connector(name, kind, kind_of_value, unit)

    def _side(self, causality: str) -> list[str]:
        variables = [v for v in self._variables.values() if v.causality == causality]
        for variable in variables:
            self._require_scalar(variable)
        return [v.name for v in variables]

    def _require_scalar(self, variable: Any) -> None:
        if variable.type not in _TYPES or variable.dimensions:
            problem = f"{variable.causality} {variable.name} must be a scalar number in SSP"
            raise InputError(problem, file=self._file)
