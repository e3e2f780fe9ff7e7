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

from .participant import Participant
from .wiring import Ported, Wiring, members

_NAMED = 4
"""Variables that a line names."""


@dataclass(frozen=True, slots=True)
class ExternalFmu:
    """Settings of an FMU that replaces one of the experiment's FMUs.

    Attributes:
        file: The .fmu.
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


def fitting_wiring(
    wiring: Wiring, fmus: Collection[str], parts: Iterable[Ported], loads: Sequence[str]
) -> dict[str, str | float]:
    """Return an experiment's wiring without external loads that external FMUs do not accept.

    Args:
        wiring: The experiment's wiring.
        fmus: The roles of external FMUs.
        parts: The participants.
        loads: Names of the inputs for loads.
    """
    missing = {
        f"{part.name}.{load}"
        for part in parts
        if part.name in fmus
        for load in loads
        if load not in part.input_names
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
        inner: The FMU, initialised.
        external: The experiment's settings for it.
        ports: The experiment's variables for the role of the FMU.

    Raises:
        InputError: A size or a unit does not match.
        UnknownNameError: The map contains a name that does not exist.

    Attributes:
        warnings: Assumptions, one line each: variables without units use the experiment's units.
    """

    def __init__(self, inner: Participant, external: ExternalFmu, ports: Sequence[Port]) -> None:
        self.name = inner.name
        self._inner = inner
        known = {port.name: port for port in ports}
        units = {**inner.units, **stated_units(external, (*inner.input_names, *inner.output_names))}
        taken, given = (
            _Side(own, renamed(external, side, own, ports), units, known, f"{external.key}.{side}s")
            for side, own in (("input", inner.input_names), ("output", inner.output_names))
        )
        self._taken, self._given = taken, given
        assumed = [*taken.assumed, *given.assumed]
        self.warnings = [_assumption(external.key, assumed)] if assumed else []
        self.input_names, self.output_names = taken.names, given.names
        self.units: Mapping[str, Unit] = {**given.units, **taken.units}
        self.inputs: FloatArray = taken.outside(inner.inputs)
        self.outputs: FloatArray = given.outside(inner.outputs)

    def step(self, t: float, h: float) -> None:
        """Convert the inputs, step the FMU, convert its outputs."""
        self._taken.inside(self.inputs, self._inner.inputs)
        self._inner.step(t, h)
        self.outputs[:] = self._given.outside(self._inner.outputs)

    def close(self) -> None:
        """Free the FMU."""
        self._inner.close()


class _Side:
    """Inputs or outputs of an FMU with other names and units."""

    def __init__(
        self,
        own: Sequence[str],
        renamed: Mapping[str, str],
        units: Mapping[str, Unit],
        ports: Mapping[str, Port],
        key: str,
    ) -> None:
        self.names = tuple(renamed.get(name, name) for name in own)
        if len(set(self.names)) < len(self.names):
            twice = next(name for name in self.names if self.names.count(name) > 1)
            raise InputError(f"two variables would have the name {twice!r}", key=key)
        self.units: dict[str, Unit] = {}
        self.assumed: list[str] = []
        changes = []
        for name in own:
            unit, new = units.get(name), renamed.get(name)
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
        self._factors = np.array([change.factor for change in changes])
        self._offsets = np.array([change.offset for change in changes])

    def outside(self, values: FloatArray) -> FloatArray:
        """Return the FMU's values in the experiment's units."""
        converted: FloatArray = self._factors * values + self._offsets
        return converted

    def inside(self, values: FloatArray, target: FloatArray) -> None:
        """Return the experiment's values in the FMU's units."""
        target[:] = (values - self._offsets) / self._factors


def _assumption(key: str, assumed: Sequence[str]) -> str:
    more = f" and {len(assumed) - _NAMED} more" if len(assumed) > _NAMED else ""
    line = f"{key}: the FMU has no units for {', '.join(assumed[:_NAMED])}{more}"
    return f"{line}; the experiment's units are assumed; set {key}.units for other units"


def _conversion(source: Unit | None, target: Unit | None, route: str) -> Conversion:
    try:
        return conversion(source, target)
    except InputError as error:
        raise InputError(error.what, key=route) from None


def stated_units(external: ExternalFmu, own: Sequence[str]) -> dict[str, Unit]:
    """Return the units that the experiment specifies for variables of an FMU.

    Raises:
        UnknownNameError: A variable does not exist.
    """
    units: dict[str, Unit] = {}
    for name, unit in external.units.items():
        variables = members(name, own)
        if not variables:
            raise UnknownNameError("variable of the FMU", name, own, key=f"{external.key}.units")
        units |= dict.fromkeys(variables, KNOWN_UNITS[unit])
    return units


def renamed(
    external: ExternalFmu, side: str, own: Sequence[str], ports: Sequence[Port]
) -> dict[str, str]:
    """Return the experiment's name of each mapped variable of an FMU.

    Args:
        external: The experiment's settings for the FMU.
        side: `input` or `output`.
        own: Names of the FMU's variables on that side.
        ports: The experiment's variables for the role of the FMU.

    Raises:
        InputError: A size does not match.
        UnknownNameError: The map contains a name that does not exist.
    """
    ours = [port.name for port in ports if port.causality == side]
    key = f"{external.key}.{side}s"
    names: dict[str, str] = {}
    for name, variable in (external.inputs if side == "input" else external.outputs).items():
        mapped, variables = members(name, ours), members(variable, own)
        if not mapped:
            raise UnknownNameError(side, name, ours, key=key)
        if not variables:
            raise UnknownNameError(f"{side} of the FMU", variable, own, key=f"{key}.{name}")
        if len(mapped) != len(variables):
            what = f"{name} has {len(mapped)}, {variable} of the FMU {len(variables)}"
            raise InputError(f"sizes do not match: {what}", key=f"{key}.{name}")
        for port, one in zip(mapped, variables, strict=True):
            if one in names:
                raise InputError(f"{one} is mapped twice", key=f"{key}.{name}")
            names[one] = port
    return names
