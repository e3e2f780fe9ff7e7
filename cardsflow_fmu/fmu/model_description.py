"""Writes modelDescription.xml: what FMI 2.0 and FMI 3.0 have in common, and the choice of one."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from addin_sdfusion.robot import InputError, UnknownNameError
from cardsflow_fmu.signals.ports import Port
from cardsflow_fmu.signals.units import SI_UNITS
from cardsflow_fmu.signals.variables import Variable
from cardsflow_fmu.version import __version__

FmiVersion = Literal["2.0", "3.0"]
FMI_VERSIONS: tuple[FmiVersion, ...] = ("2.0", "3.0")

LICENSE_NAME = "BSD-3-Clause"

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
    "logEvents": "Instantiation, initialization, reset and end",
    "logStatusWarning": "Calls that were answered with a warning",
    "logStatusDiscard": "Calls that were answered with discard",
    "logStatusError": "Why a call failed",
    "logAll": "All of these",
}

_PART = r"([A-Za-z_][A-Za-z0-9_]*|'([^'\\\x00-\x1f\x7f-\U0010ffff]|\\['\"?\\abfnrtv])+')"
_INDICES = r"(\[[0-9]+(,[0-9]+)*\])?"
_STRUCTURED_NAME = re.compile(rf"{_PART}{_INDICES}(\.{_PART}{_INDICES})*")
_IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_CONTINUOUS_OR_DISCRETE = ("continuous", "discrete")


@dataclass(frozen=True, slots=True)
class FmuDescription:
    """What a model description tells of an FMU.

    Attributes:
        variables: The variables, which hold all ports of the model in their order.
        model_name: Name of the model and of its library: a C identifier.
        description: One line for people.
        step: Preferred communication step, in [s].
        stop_time: Preferred end, in [s].
        internal_step: What communication steps have to be multiples of, in [s].
        any_step: Whether communication steps may have any length.
        has_derivatives: Whether the model has directional derivatives.
        has_state: Whether it can go back to an earlier state.
        needs_tool: Whether a Python with this package has to be there.
        sources: C files in the FMU that its library is compiled of, relative to its sources.
    """

    variables: Sequence[Variable]
    model_name: str
    description: str
    step: float
    stop_time: float | None = None
    internal_step: float | None = None
    any_step: bool = False
    has_derivatives: bool = False
    has_state: bool = True
    needs_tool: bool = True
    sources: Sequence[str] = ()

    @property
    def ports(self) -> list[Port]:
        """The model's table."""
        return [port for variable in self.variables for port in variable.ports]


def model_description(fmu: FmuDescription, guid: str, fmi: FmiVersion = "2.0") -> bytes:
    """The contents of modelDescription.xml.

    Args:
        fmu: What to describe.
        guid: What the library has to answer to.
        fmi: Version of FMI; FMI 2.0 has no arrays.

    Raises:
        InputError: A name, a unit or a combination of attributes that FMI does not allow.
    """
    from .fmi2 import describe as describe_2
    from .fmi3 import describe as describe_3

    _check(fmu)
    root = describe_2(fmu, guid) if fmi == "2.0" else describe_3(fmu, guid)
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def root_element(fmu: FmuDescription, **attributes: str) -> ET.Element:
    """The root of a model description.

    Args:
        fmu: What to describe.
        attributes: Those that come first.
    """
    return ET.Element(
        "fmiModelDescription",
        attributes,
        modelName=fmu.model_name,
        description=fmu.description,
        version=__version__,
        license=LICENSE_NAME,
        generationTool=f"CARDSFlow {__version__}",
        variableNamingConvention="structured",
    )


def flag(value: bool) -> str:
    """A truth value in XML."""
    return "true" if value else "false"


def number(value: float) -> str:
    """A number that reads back exactly."""
    return repr(float(value))


def start(port: Port) -> str:
    """The start value of a port."""
    return flag(port.start != 0) if port.boolean else number(port.start)


def unit_definitions(fmu: FmuDescription) -> list[ET.Element]:
    """The element with the units that are used; nothing without any."""
    definitions = ET.Element("UnitDefinitions")
    used = {variable.unit for variable in fmu.variables}
    for name, exponents in SI_UNITS.items():
        if name in used:
            unit = ET.SubElement(definitions, "Unit", name=name)
            ET.SubElement(unit, "BaseUnit", {base: str(n) for base, n in exponents.items()})
    return [definitions] if len(definitions) else []


def type_names(fmu: FmuDescription) -> dict[str, str]:
    """Names of the types that variables are declared by, by unit: a type a quantity.

    A type must not share its name with a variable.
    """
    taken = {variable.name for variable in fmu.variables}
    used = {variable.unit for variable in fmu.variables}
    return {u: name for u, name in _QUANTITIES.items() if u in used and name not in taken}


def log_categories() -> ET.Element:
    """The element with the log categories."""
    categories = ET.Element("LogCategories")
    for name, description in _LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=description)
    return categories


def default_experiment(fmu: FmuDescription) -> ET.Element:
    """The element with the preferred times."""
    experiment = ET.Element("DefaultExperiment", startTime="0.0")
    if fmu.stop_time is not None:
        experiment.set("stopTime", number(fmu.stop_time))
    experiment.set("stepSize", number(fmu.step))
    return experiment


def _check(fmu: FmuDescription) -> None:
    if not _IDENTIFIER.fullmatch(fmu.model_name):
        raise InputError(f"an FMU's model name is letters, digits and _, unlike {fmu.model_name!r}")
    if not fmu.variables:
        raise InputError(f"the FMU {fmu.model_name} needs at least one variable")
    if not 0 < fmu.step < float("inf"):
        raise InputError(f"an FMU's step is a positive time in s, not {fmu.step!r}")
    for names in ([p.name for p in fmu.ports], [v.name for v in fmu.variables]):
        if len(set(names)) < len(names):
            twice = sorted({name for name in names if names.count(name) > 1})
            raise InputError(f"variables with the same name: {', '.join(twice)}")
    _check_text(fmu.description)
    for port in fmu.ports:
        _check_port(port)


def _check_port(port: Port) -> None:
    if not _STRUCTURED_NAME.fullmatch(port.name):
        raise InputError(f"{port.name!r} is not a structured FMI variable name")
    _check_text(port.description)
    if port.unit and port.unit not in SI_UNITS:
        raise UnknownNameError(f"unit of {port.name}:", port.unit, SI_UNITS)
    is_signal = port.variability in _CONTINUOUS_OR_DISCRETE
    if is_signal == (port.causality == "parameter"):
        raise InputError(f"{port.name}: a {port.causality} cannot be {port.variability}")
    if port.boolean and port.variability == "continuous":
        raise InputError(f"{port.name}: a boolean variable cannot be continuous")
    if port.boolean and port.start not in (0, 1):
        raise InputError(f"{port.name}: a boolean variable starts at 0 or 1, not {port.start!r}")
    if port.start - port.start != 0:
        raise InputError(f"{port.name}: the start value {port.start!r} is not finite")


def _check_text(text: str) -> None:
    if _NOT_IN_XML.search(text):
        raise InputError(f"{text!r} has characters that XML cannot hold")
