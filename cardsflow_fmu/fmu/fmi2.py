"""Model descriptions of FMI 2.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from cardsflow_fmu.cosim.signals.variables import Variable

from .description import (
    FmuDescription,
    display_unit,
    document,
    format_flag,
    format_start,
    number_attributes,
    type_names,
)
from .structure import add_unknowns, indicators, mark_states, unknowns_of

_UNKNOWNS = {"output": "Outputs", "derivative": "Derivatives", "initial": "InitialUnknowns"}
"""Elements for kinds of unknowns. FMI 2.0 only counts event indicators."""


def describe(fmu: FmuDescription, guid: str) -> ET.Element:
    """Return the root element of a model description of FMI 2.0."""
    types = type_names(fmu)
    identity = {"fmiVersion": "2.0", "guid": guid}
    variables = [_variable(variable, types) for variable in fmu.variables]
    interface = _model_exchange(fmu) if fmu.is_continuous else _co_simulation(fmu)
    if fmu.is_continuous:
        identity["numberOfEventIndicators"] = str(len(indicators(fmu)))
        mark_states(fmu, [variable[0] for variable in variables], first=1)
    structure = _model_structure(fmu)
    return document(fmu, identity, interface, _type_definitions(types), variables, structure)


def _co_simulation(fmu: FmuDescription) -> ET.Element:
    return _interface(
        "CoSimulation",
        fmu,
        canHandleVariableCommunicationStepSize=format_flag(fmu.any_step),
        canInterpolateInputs="false",
    )


def _model_exchange(fmu: FmuDescription) -> ET.Element:
    return _interface("ModelExchange", fmu, completedIntegratorStepNotNeeded="false")


def _interface(kind: str, fmu: FmuDescription, **more: str) -> ET.Element:
    """Return the element of an interface, with the attributes of both kinds and with more."""
    element = ET.Element(
        kind,
        more,
        modelIdentifier=fmu.model_name,
        needsExecutionTool=format_flag(fmu.needs_tool),
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUstate=format_flag(fmu.has_state),
        canSerializeFMUstate=format_flag(fmu.has_state),
        providesDirectionalDerivative=format_flag(fmu.has_derivatives),
    )
    if fmu.sources:
        files = ET.SubElement(element, "SourceFiles")
        files.extend(ET.Element("File", name=name) for name in fmu.sources)
    return element


def _type_definitions(types: dict[str, str]) -> Iterator[ET.Element]:
    for unit, name in types.items():
        simple = ET.Element("SimpleType", name=name)
        ET.SubElement(simple, "Real", display_unit(unit), quantity=name, unit=unit)
        yield simple


def _variable(variable: Variable, types: dict[str, str]) -> ET.Element:
    port = variable.port
    element = ET.Element(
        "ScalarVariable",
        name=variable.name,
        valueReference=str(variable.reference),
        description=variable.description,
        causality=port.causality,
        variability=port.variability,
    )
    if port.causality != "input":
        element.set("initial", "exact" if port.causality == "parameter" else "calculated")
    tag = "Boolean" if port.boolean else "Real"
    kind = ET.SubElement(element, tag, number_attributes(variable, types))
    if port.causality in ("input", "parameter"):
        kind.set("start", format_start(port))
    return element


def _model_structure(fmu: FmuDescription) -> ET.Element:
    """Return the element `ModelStructure`. Over a step, outputs depend on inputs."""
    structure = ET.Element("ModelStructure")
    places = {variable.name: index for index, variable in enumerate(fmu.variables, 1)}
    unknowns = unknowns_of(fmu, ("input",))
    for kind, tag in _UNKNOWNS.items():
        if group := [unknown for unknown in unknowns if unknown.kind == kind]:
            parent = ET.SubElement(structure, tag)
            add_unknowns(parent, group, lambda _: "Unknown", "index", lambda v: places[v.name])
    return structure
