"""Contents of model descriptions, and elements common to FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from cardsflow_fmu.cosim.signals.dependencies import Dependencies
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.cosim.signals.units import SI_UNITS
from cardsflow_fmu.cosim.signals.variables import Variable
from cardsflow_fmu.version import __version__

FmiVersion = Literal["2.0", "3.0"]

DISPLAY_UNITS = {
    f"{unit}{per}": (f"{shown}{per}", factor)
    for unit, shown, factor in (("rad", "deg", math.degrees(1.0)), ("m", "mm", 1e3))
    for per in ("", "/s", "/s2")
}
"""Units in which tools display values, with their factors, by unit."""

_TOLERANCE = 1e-6
"""Relative tolerance of solvers for model exchange. Co-simulation uses fixed steps."""

_QUANTITIES = {
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration",
    "m": "Length",
    "m/s": "Velocity",
    "m/s2": "Acceleration",
    "N": "Force",
    "N.m": "Torque",
    "s": "Time",
    "N.m/rad": "RotationalStiffness",
    "N.m.s/rad": "RotationalDamping",
    "N/m": "Stiffness",
    "N.s/m": "Damping",
    "1/s": "Rate",
    "1/s2": "SquaredRate",
}

_LOG_CATEGORIES = {
    "logEvents": "Instantiation, initialization, reset and termination",
    "logStatusWarning": "Calls that returned a warning",
    "logStatusDiscard": "Calls that returned discard",
    "logStatusError": "Reasons for failed calls",
    "logAll": "All categories",
}


@dataclass(frozen=True, slots=True)
class FmuDescription:
    """Contents of the model description of an FMU.

    Attributes:
        variables: The variables, which contain all ports of the model in order.
        model_name: Name of the model and of its library: a C identifier.
        step: Preferred communication step, in [s].
        stop_time: Preferred end, in [s].
        internal_step: Divisor of communication steps, in [s].
        returns_early: Whether communication steps may end after any internal step.
        any_step: Whether communication steps may have any length.
        has_derivatives: Whether the model has directional derivatives.
        has_state: Whether an earlier state can be restored.
        needs_tool: Whether Python with this package is required.
        is_continuous: Whether the FMU is for model exchange; otherwise it is for co-simulation.
        dependencies: Dependencies of the outputs. If None, outputs depend on all inputs.
        sources: C files in the FMU from which its library is compiled, relative to its sources.
        about: Attributes `author`, `copyright` and `license`, if specified.
        generated: Time of the build in ISO 8601; empty to omit it.
    """

    variables: Sequence[Variable]
    model_name: str
    description: str
    step: float
    stop_time: float | None = None
    internal_step: float | None = None
    returns_early: bool = False
    any_step: bool = False
    has_derivatives: bool = False
    has_state: bool = True
    needs_tool: bool = True
    sources: Sequence[str] = ()
    dependencies: Dependencies | None = None
    is_continuous: bool = False
    about: Mapping[str, str] = field(default_factory=dict)
    generated: str = ""

    @property
    def ports(self) -> list[Port]:
        """Ports of the model."""
        return [port for variable in self.variables for port in variable.ports]


def xml_bytes(root: ET.Element) -> bytes:
    """Return the content of an XML file."""
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def document(
    fmu: FmuDescription,
    identity: Mapping[str, str],
    interface: ET.Element,
    types: Iterable[ET.Element],
    variables: Iterable[ET.Element],
    structure: ET.Element,
) -> ET.Element:
    """Return the root element of a model description with the parts common to both versions."""
    about = {**fmu.about, "generationDateAndTime": fmu.generated}
    root = ET.Element(
        "fmiModelDescription",
        {**identity, **{key: text for key, text in about.items() if text}},
        modelName=fmu.model_name,
        description=fmu.description,
        version=__version__,
        generationTool=f"CARDSFlow {__version__}",
        variableNamingConvention="structured",
    )
    root.append(interface)
    for tag, elements in (
        ("UnitDefinitions", _units(fmu)),
        ("TypeDefinitions", types),
        ("LogCategories", _log_categories()),
    ):
        group = ET.Element(tag)
        group.extend(elements)
        if len(group):
            root.append(group)
    root.append(_default_experiment(fmu))
    ET.SubElement(root, "ModelVariables").extend(variables)
    root.append(structure)
    return root


def format_flag(value: bool) -> str:
    """Format a boolean for XML."""
    return "true" if value else "false"


def format_number(value: float) -> str:
    """Format a number so that it reads back exactly."""
    return repr(float(value))


def format_start(port: Port) -> str:
    """Format the start value of a port."""
    return format_flag(port.start != 0) if port.boolean else format_number(port.start)


def _units(fmu: FmuDescription) -> Iterator[ET.Element]:
    """Yield the definitions of all units that variables use."""
    used = {variable.unit for variable in fmu.variables}
    for name, exponents in SI_UNITS.items():
        if name in used:
            unit = ET.Element("Unit", name=name)
            ET.SubElement(unit, "BaseUnit", {base: str(n) for base, n in exponents.items()})
            if name in DISPLAY_UNITS:
                shown, factor = DISPLAY_UNITS[name]
                ET.SubElement(unit, "DisplayUnit", name=shown, factor=format_number(factor))
            yield unit


def type_names(fmu: FmuDescription) -> dict[str, str]:
    """Return the type names of variables by unit, one type per quantity.

    A type must not share its name with a variable.
    """
    names = {variable.name for variable in fmu.variables}
    used = {variable.unit for variable in fmu.variables}
    return {u: name for u, name in _QUANTITIES.items() if u in used and name not in names}


def display_unit(unit: str) -> dict[str, str]:
    """Return the attribute for the unit in which tools display values; empty for others."""
    return {"displayUnit": DISPLAY_UNITS[unit][0]} if unit in DISPLAY_UNITS else {}


def number_attributes(variable: Variable, types: Mapping[str, str]) -> dict[str, str]:
    """Return the attributes of a variable that both versions share: type, unit, range, nominal.

    An array has the range that contains the ranges of all elements, and the smallest nominal value.
    """
    ports, unit = variable.ports, variable.unit
    if variable.port.boolean:
        return {}
    attributes = {"unit": unit} if unit else {}
    attributes |= {"declaredType": types[unit]} if unit in types else display_unit(unit)
    values = {
        "min": min(port.lower for port in ports),
        "max": max(port.upper for port in ports),
        "nominal": min(port.nominal for port in ports),
    }
    standard = {"min": -math.inf, "max": math.inf, "nominal": 1.0}
    return attributes | {
        key: format_number(value) for key, value in values.items() if value != standard[key]
    }


def _log_categories() -> Iterator[ET.Element]:
    for name, description in _LOG_CATEGORIES.items():
        yield ET.Element("Category", name=name, description=description)


def _default_experiment(fmu: FmuDescription) -> ET.Element:
    experiment = ET.Element("DefaultExperiment", startTime="0.0")
    if fmu.stop_time is not None:
        experiment.set("stopTime", format_number(fmu.stop_time))
    if fmu.is_continuous:
        experiment.set("tolerance", format_number(_TOLERANCE))
    experiment.set("stepSize", format_number(fmu.step))
    return experiment
