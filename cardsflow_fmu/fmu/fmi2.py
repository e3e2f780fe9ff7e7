"""Model descriptions of FMI 2.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from cardsflow_fmu.cosim.signals.variables import Variable

from . import model_exchange
from .description import (
    FmuDescription,
    dependency_indices,
    display_unit,
    document,
    format_flag,
    format_start,
    number_attributes,
    type_names,
)


def describe(fmu: FmuDescription, guid: str) -> ET.Element:
    """Return the root element of a model description of FMI 2.0."""
    types = type_names(fmu)
    identity = {"fmiVersion": "2.0", "guid": guid}
    variables = [_variable(variable, types) for variable in fmu.variables]
    interface, structure = _co_simulation(fmu), _model_structure(fmu)
    if fmu.is_continuous:
        identity["numberOfEventIndicators"] = str(len(model_exchange.indicators(fmu)))
        model_exchange.mark_states(fmu, [variable[0] for variable in variables], first=1)
        interface = _model_exchange(fmu)
        structure = model_exchange.structure_2(fmu, structure)
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
    """Return the element `ModelStructure`.

    It declares dependencies on inputs over a step, and on inputs and parameters at the start.
    """
    structure = ET.Element("ModelStructure")
    outputs = [(i, v) for i, v in enumerate(fmu.variables, 1) if v.port.causality == "output"]
    knowns = {"Outputs": ("input",), "InitialUnknowns": ("input", "parameter")}
    for tag, causalities in knowns.items() if outputs else ():
        unknowns = ET.SubElement(structure, tag)
        for index, variable in outputs:
            unknown = ET.SubElement(unknowns, "Unknown", index=str(index))
            at_start = tag == "InitialUnknowns"
            indices = dependency_indices(fmu, variable, causalities, at_start=at_start)
            if indices is not None:
                unknown.set("dependencies", " ".join(str(k + 1) for k in indices))
    return structure
