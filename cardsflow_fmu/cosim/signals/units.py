"""Units of variables: SI base exponents, and conversions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from addin_sdfusion.robot import InputError

SI_UNITS: dict[str, dict[str, int]] = {
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "s": {"s": 1},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N.m.s/rad": {"kg": 1, "m": 2, "s": -1, "rad": -1},
    "N/m": {"kg": 1, "s": -2},
    "N.s/m": {"kg": 1, "s": -1},
    "1/s": {"s": -1},
    "1/s2": {"s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "A": {"A": 1},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa/s": {"kg": 1, "m": -1, "s": -3},
    "N.s": {"kg": 1, "m": 1, "s": -1},
    "N.m.s": {"kg": 1, "m": 2, "s": -1},
    "1": {},
}
"""Units that this package writes, by name, with exponents of the SI base units."""

BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_DEGREE = 3.141592653589793 / 180.0
_SCALED = {
    "deg": ("rad", _DEGREE),
    "deg/s": ("rad/s", _DEGREE),
    "deg/s2": ("rad/s2", _DEGREE),
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "mm/s": ("m/s", 1e-3),
    "cm/s": ("m/s", 1e-2),
    "kN": ("N", 1e3),
    "N.mm": ("N.m", 1e-3),
    "kN.m": ("N.m", 1e3),
    "ms": ("s", 1e-3),
    "kPa": ("Pa", 1e3),
    "bar": ("Pa", 1e5),
}


@dataclass(frozen=True, slots=True)
class Unit:
    """Unit of measurement: value in SI base units = factor · value + offset.

    Attributes:
        name: Name, such as `deg`.
        exponents: Exponents of kg, m, s, A, K, mol, cd and rad, or None if unknown. Then the unit
            is only compatible with units of the same name.
        factor: Factor, such as pi / 180.
        offset: Offset, such as 273.15 for degC.
    """

    name: str
    exponents: tuple[int, ...] | None
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Conversion:
    """Conversion between units: factor · value + offset."""

    factor: float = 1.0
    offset: float = 0.0

    @property
    def is_identity(self) -> bool:
        """Whether the conversion leaves values unchanged."""
        return self.factor == 1.0 and self.offset == 0.0


def _named(name: str, exponents: Mapping[str, int], factor: float = 1.0) -> Unit:
    return Unit(name, tuple(exponents.get(base, 0) for base in BASES), factor)


KNOWN_UNITS: dict[str, Unit] = {
    **{name: _named(name, exponents) for name, exponents in SI_UNITS.items()},
    **{name: _named(name, SI_UNITS[si], factor) for name, (si, factor) in _SCALED.items()},
}
"""Units by name, for variables whose unit the FMU does not define."""
_NUMBER = KNOWN_UNITS["1"]


def conversion(source: Unit | None, target: Unit | None) -> Conversion:
    """Return the conversion from one unit to another.

    Args:
        source: Unit of the value, or None for a value without a unit.
        target: Desired unit, or None for a value without a unit.

    Raises:
        InputError: The units have different dimensions, or one of them is missing.
    """
    if source is None and target is None:
        return Conversion()
    if source is None or target is None:
        names = [repr(unit.name) if unit else "no unit" for unit in (source, target)]
        raise InputError(f"{names[0]} is not compatible with {names[1]}; specify the missing unit")
    if None in (source.exponents, target.exponents) and source.name == target.name:
        return Conversion()
    if None in (source.exponents, target.exponents) or source.exponents != target.exponents:
        problem = f"{source.name!r} is not compatible with {target.name!r}"
        raise InputError(f"{problem}: {_in_bases(source)} is not {_in_bases(target)}")
    for unit in (source, target):
        if unit.factor == 0.0 or not (math.isfinite(unit.factor) and math.isfinite(unit.offset)):
            problem = f"has the invalid factor {unit.factor:g} or offset {unit.offset:g}"
            raise InputError(f"the unit {unit.name!r} {problem}")
    if (source.factor, source.offset) == (target.factor, target.offset):
        return Conversion()
    return Conversion(
        source.factor / target.factor, (source.offset - target.offset) / target.factor
    )


def variable_units(description: Any) -> dict[str, Unit]:
    """Return the units of an FMU's variables, by name. Variables without a unit have no entry.

    A unit that the FMU does not define is the unit of this package with the same name. An unknown
    unit is only compatible with itself.
    """
    defined = {unit.name: _defined(unit) for unit in description.unitDefinitions}
    units = {}
    for variable in description.modelVariables:
        name = variable.unit or getattr(variable.declaredType, "unit", None)
        unit = defined.get(name) or KNOWN_UNITS.get(name) or Unit(name, None) if name else _NUMBER
        if replace(unit, name="1") != _NUMBER:
            units[variable.name] = unit
    return units


def _defined(unit: Any) -> Unit | None:
    """Return a unit that an FMU defines, or None if the definition contains only a name."""
    base = unit.baseUnit
    if base is None:
        return None
    exponents = tuple(int(getattr(base, name) or 0) for name in BASES)
    factor = 1.0 if base.factor is None else float(base.factor)
    return Unit(unit.name, exponents, factor, float(base.offset or 0.0))


def _in_bases(unit: Unit) -> str:
    if unit.exponents is None:
        return "an undefined unit"
    parts = [
        base if exponent == 1 else f"{base}{exponent}"
        for base, exponent in zip(BASES, unit.exponents, strict=True)
        if exponent
    ]
    return ".".join(parts) or "a number"
