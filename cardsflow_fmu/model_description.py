"""Writes modelDescription.xml for FMI 2.0 co-simulation."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence

from addin_sdfusion.robot import InputError, UnknownNameError

from .ports import Port
from .version import __version__

_BASE_UNITS: dict[str, dict[str, int]] = {
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


def model_description(
    ports: Sequence[Port],
    *,
    model_name: str,
    guid: str,
    description: str,
    step: float,
    stop_time: float | None = None,
) -> bytes:
    """The contents of modelDescription.xml.

    Args:
        ports: The variables; the value reference is the index.
        model_name: Name of the model and of its library: a C identifier.
        guid: What the library has to answer to.
        description: One line for people.
        step: Preferred communication step, in [s].
        stop_time: Preferred end, in [s].

    Raises:
        InputError: A name, a unit or a combination of attributes that FMI does not allow.
    """
    _check(ports, model_name, description)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model_name,
        guid=guid,
        description=description,
        version=__version__,
        generationTool=f"CARDSFlow {__version__}",
        variableNamingConvention="structured",
    )
    root.append(_co_simulation(model_name))
    units = _unit_definitions(ports)
    if len(units):
        root.append(units)
    root.append(_log_categories())
    root.append(_default_experiment(step, stop_time))
    variables = ET.SubElement(root, "ModelVariables")
    variables.extend(_variable(reference, port) for reference, port in enumerate(ports))
    root.append(_model_structure(ports))
    ET.indent(root)
    text: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _check(ports: Sequence[Port], model_name: str, description: str) -> None:
    if not _IDENTIFIER.fullmatch(model_name):
        raise InputError(f"an FMU's model name is letters, digits and _, unlike {model_name!r}")
    if not ports:
        raise InputError(f"the FMU {model_name} needs at least one variable")
    names = [port.name for port in ports]
    twice = (
        {name for name in names if names.count(name) > 1} if len(set(names)) < len(names) else ()
    )
    if twice:
        raise InputError(f"variables with the same name: {', '.join(sorted(twice))}")
    _check_text(description)
    for port in ports:
        _check_port(port)


def _check_port(port: Port) -> None:
    if not _STRUCTURED_NAME.fullmatch(port.name):
        raise InputError(f"{port.name!r} is not a structured FMI variable name")
    _check_text(port.description)
    if port.unit and port.unit not in _BASE_UNITS:
        raise UnknownNameError(f"unit of {port.name}:", port.unit, _BASE_UNITS)
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


def _co_simulation(model_name: str) -> ET.Element:
    return ET.Element(
        "CoSimulation",
        modelIdentifier=model_name,
        needsExecutionTool="true",
        canHandleVariableCommunicationStepSize="false",
        canInterpolateInputs="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        providesDirectionalDerivative="false",
    )


def _unit_definitions(ports: Sequence[Port]) -> ET.Element:
    definitions = ET.Element("UnitDefinitions")
    used = {port.unit for port in ports}
    for name, exponents in _BASE_UNITS.items():
        if name in used:
            unit = ET.SubElement(definitions, "Unit", name=name)
            ET.SubElement(unit, "BaseUnit", {base: str(n) for base, n in exponents.items()})
    return definitions


def _log_categories() -> ET.Element:
    categories = ET.Element("LogCategories")
    for name, description in _LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=description)
    return categories


def _default_experiment(step: float, stop_time: float | None) -> ET.Element:
    experiment = ET.Element("DefaultExperiment", startTime="0.0")
    if stop_time is not None:
        experiment.set("stopTime", _number(stop_time))
    experiment.set("stepSize", _number(step))
    return experiment


def _number(value: float) -> str:
    """A number that reads back exactly."""
    return repr(float(value))


def _variable(reference: int, port: Port) -> ET.Element:
    variable = ET.Element(
        "ScalarVariable",
        name=port.name,
        valueReference=str(reference),
        description=port.description,
        causality=port.causality,
        variability=port.variability,
    )
    if port.causality != "input":
        variable.set("initial", "exact" if port.causality == "parameter" else "calculated")
    kind = ET.SubElement(variable, "Boolean" if port.boolean else "Real")
    if port.causality != "output":
        kind.set("start", _start(port))
    if port.unit and not port.boolean:
        kind.set("unit", port.unit)
    return variable


def _start(port: Port) -> str:
    if port.boolean:
        return "true" if port.start else "false"
    return _number(port.start)


def _model_structure(ports: Sequence[Port]) -> ET.Element:
    """Every output depends on everything, at the start as well."""
    structure = ET.Element("ModelStructure")
    outputs = [index for index, port in enumerate(ports, 1) if port.causality == "output"]
    for tag in ("Outputs", "InitialUnknowns") if outputs else ():
        unknowns = ET.SubElement(structure, tag)
        unknowns.extend(ET.Element("Unknown", index=str(index)) for index in outputs)
    return structure
