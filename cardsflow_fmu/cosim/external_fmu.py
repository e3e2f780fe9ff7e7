"""External FMUs: name maps, and a participant with mapped names and units."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Conversion, Unit, conversion
from cardsflow_fmu.utils.arrays import FloatArray

from .participant import Copy, CStep, Form, Participant
from .wiring import Ported, Wiring, members

_MAX_NAMED = 4
"""Maximum number of variables named in a warning."""


_loaded: set[Path] = set()


def is_loaded() -> bool:
    """Return whether this process has loaded the library of an external FMU."""
    return bool(_loaded)


@dataclass(frozen=True, slots=True)
class ExternalFmu:
    """Settings of an FMU that replaces one of the experiment's FMUs.

    Attributes:
        key: Key of the setting for messages, such as `fmus.plant`.
        inputs: The FMU's variable for each input port of the experiment, by the port's name. A name
            may be the name of a group of ports or of an array.
        outputs: The same for the output ports.
        units: Units of variables for which the FMU specifies none, by the variable's name.
        parameters: Start values by the FMU's names, in the FMU's units.
    """

    file: Path
    key: str = "fmus"
    inputs: Mapping[str, str] = field(default_factory=dict)
    outputs: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, float] = field(default_factory=dict)


def without_missing_loads(
    wiring: Wiring, fmus: Collection[str], models: Iterable[Ported], loads: Sequence[str]
) -> dict[str, str | float]:
    """Return an experiment's wiring without loads that external FMUs have no inputs for."""
    missing = {
        f"{model.name}.{load}"
        for model in models
        if model.name in fmus
        for load in loads
        if load not in model.input_names
    }
    return {
        target: source
        for target, source in wiring.items()
        if target not in missing or isinstance(source, str)
    }


class AdaptedFmu:
    """Participant with the experiment's names and units.

    Mapped ports have the experiment's names and are converted to its units. All other variables
    keep their names and units.

    Args:
        inner: The initialised FMU.
        ports: The experiment's variables for the role of the FMU.

    Raises:
        InputError: A size or a unit does not match.
        UnknownNameError: The map contains a name that does not exist.

    Attributes:
        warnings: Assumptions, one line each: variables without units use the experiment's units.
        incoming, outgoing: Conversions before and after a step.
    """

    def __init__(self, inner: Participant, external: ExternalFmu, ports: Sequence[Port]) -> None:
        _loaded.add(external.file)
        self.name = inner.name
        ports_by_name = {port.name: port for port in ports}
        units = {
            **inner.units,
            **specified_units(external, (*inner.input_names, *inner.output_names)),
        }
        inputs, outputs = (
            _MappedPorts(
                names,
                experiment_names(external, side, names, ports),
                units,
                ports_by_name,
                f"{external.key}.{side}s",
            )
            for side, names in (("input", inner.input_names), ("output", inner.output_names))
        )
        assumed = [*inputs.assumed, *outputs.assumed]
        self.warnings = [_assumption(external.key, assumed)] if assumed else []
        self.input_names, self.output_names = inputs.names, outputs.names
        self.units: Mapping[str, Unit] = {**outputs.units, **inputs.units}
        self.inputs: FloatArray = inputs.to_experiment(inner.inputs)
        self.outputs: FloatArray = outputs.to_experiment(inner.outputs)
        self.step = inner.step  # converts nothing; the master makes the copies
        self.close = inner.close
        self.c_step: CStep | None = getattr(inner, "c_step", None)
        self.incoming = [
            Copy(self.inputs, k, inner.inputs, k, Form.UNSCALED, change)
            for k, change in enumerate(inputs.changes)
        ]
        self.outgoing = [
            Copy(inner.outputs, k, self.outputs, k, Form.SCALED, change)
            for k, change in enumerate(outputs.changes)
        ]


class _MappedPorts:
    """Inputs or outputs of an FMU with the experiment's names and units.

    Args:
        mapped: The experiment's name of each mapped variable.
        key: Key of the setting, for messages.

    Attributes:
        names: The experiment's names; unmapped variables keep their names.
        units: Units by the experiment's names.
        assumed: Variables without units, with the assumed unit.
        changes: Conversion of each variable to the experiment's units.
    """

    def __init__(
        self,
        fmu_names: Sequence[str],
        mapped: Mapping[str, str],
        units: Mapping[str, Unit],
        ports: Mapping[str, Port],
        key: str,
    ) -> None:
        self.names = tuple(mapped.get(name, name) for name in fmu_names)
        if len(set(self.names)) < len(self.names):
            twice = next(name for name in self.names if self.names.count(name) > 1)
            raise InputError(f"two variables would have the name {twice!r}", key=key)
        self.units: dict[str, Unit] = {}
        self.assumed: list[str] = []
        changes = []
        for name in fmu_names:
            unit, new = units.get(name), mapped.get(name)
            port = ports.get(new or name)
            port_unit = KNOWN_UNITS[port.unit] if port is not None and port.unit else None
            if unit is None and port_unit is not None:
                self.assumed.append(f"{name} in {port_unit.name}")
                unit = port_unit
            change = Conversion()
            if new is not None:
                change, unit = _conversion(unit, port_unit, f"{key}: {name} -> {new}"), port_unit
            if unit is not None:
                self.units[new or name] = unit
            changes.append(change)
        self.changes = changes

    def to_experiment(self, values: FloatArray) -> FloatArray:
        """Return the FMU's values, converted to the experiment's units."""
        changed = [c.factor * v + c.offset for v, c in zip(values, self.changes, strict=True)]
        return np.array(changed, float)


def _assumption(key: str, assumed: Sequence[str]) -> str:
    more = f" and {len(assumed) - _MAX_NAMED} more" if len(assumed) > _MAX_NAMED else ""
    line = f"{key}: the FMU specifies no units for {', '.join(assumed[:_MAX_NAMED])}{more}"
    return f"{line}; the experiment's units are assumed; set {key}.units for other units"


def _conversion(source: Unit | None, target: Unit | None, route: str) -> Conversion:
    try:
        return conversion(source, target)
    except InputError as error:
        raise InputError(error.problem, key=route) from None


def specified_units(external: ExternalFmu, fmu_names: Sequence[str]) -> dict[str, Unit]:
    """Return the units that the experiment specifies for variables of an FMU."""
    units: dict[str, Unit] = {}
    for name, unit in external.units.items():
        variables = members(name, fmu_names)
        if not variables:
            key = f"{external.key}.units"
            raise UnknownNameError("variable of the FMU", name, fmu_names, key=key)
        units |= dict.fromkeys(variables, KNOWN_UNITS[unit])
    return units


def experiment_names(
    external: ExternalFmu, side: str, fmu_names: Sequence[str], ports: Sequence[Port]
) -> dict[str, str]:
    """Return the experiment's name of each mapped variable of an FMU.

    Raises:
        InputError: A size does not match.
        UnknownNameError: The map contains a name that does not exist.
    """
    port_names = [port.name for port in ports if port.causality == side]
    key = f"{external.key}.{side}s"
    names: dict[str, str] = {}
    for name, variable in (external.inputs if side == "input" else external.outputs).items():
        mapped, variables = members(name, port_names), members(variable, fmu_names)
        if not mapped:
            raise UnknownNameError(side, name, port_names, key=key)
        if not variables:
            raise UnknownNameError(f"{side} of the FMU", variable, fmu_names, key=f"{key}.{name}")
        if len(mapped) != len(variables):
            problem = f"{name} has {len(mapped)}, {variable} of the FMU {len(variables)}"
            raise InputError(f"sizes do not match: {problem}", key=f"{key}.{name}")
        for port, fmu_name in zip(mapped, variables, strict=True):
            if fmu_name in names:
                raise InputError(f"{fmu_name} is mapped twice", key=f"{key}.{name}")
            names[fmu_name] = port
    return names
