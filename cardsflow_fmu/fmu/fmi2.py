"""Model descriptions of FMI 2.0 for co-simulation."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from cardsflow_fmu.signals.variables import Variable

from .description import (
    FmuDescription,
    default_experiment,
    flag,
    log_categories,
    root_element,
    start,
    type_names,
    unit_definitions,
)


def describe(fmu: FmuDescription, guid: str) -> ET.Element:
    """The root element."""
    root = root_element(fmu, fmiVersion="2.0", guid=guid)
    root.append(_co_simulation(fmu))
    root.extend(unit_definitions(fmu))
    types = type_names(fmu)
    if types:
        root.append(_type_definitions(types))
    root.append(log_categories())
    root.append(default_experiment(fmu))
    variables = ET.SubElement(root, "ModelVariables")
    variables.extend(_variable(variable, types) for variable in fmu.variables)
    root.append(_model_structure(fmu))
    return root


def _co_simulation(fmu: FmuDescription) -> ET.Element:
    element = ET.Element(
        "CoSimulation",
        modelIdentifier=fmu.model_name,
        needsExecutionTool=flag(fmu.needs_tool),
        canHandleVariableCommunicationStepSize=flag(fmu.any_step),
        canInterpolateInputs="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUstate=flag(fmu.has_state),
        canSerializeFMUstate=flag(fmu.has_state),
        providesDirectionalDerivative=flag(fmu.has_derivatives),
    )
    if fmu.sources:
        files = ET.SubElement(element, "SourceFiles")
        files.extend(ET.Element("File", name=name) for name in fmu.sources)
    return element


def _type_definitions(types: dict[str, str]) -> ET.Element:
    definitions = ET.Element("TypeDefinitions")
    for unit, name in types.items():
        simple = ET.SubElement(definitions, "SimpleType", name=name)
        ET.SubElement(simple, "Real", quantity=name, unit=unit)
    return definitions


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
    kind = ET.SubElement(element, "Boolean" if port.boolean else "Real")
    if port.unit in types and not port.boolean:
        kind.set("declaredType", types[port.unit])
    if port.causality != "output":
        kind.set("start", start(port))
    if port.unit and not port.boolean:
        kind.set("unit", port.unit)
    return element


def _model_structure(fmu: FmuDescription) -> ET.Element:
    """Every output depends on everything, at the start as well."""
    structure = ET.Element("ModelStructure")
    outputs = [i for i, v in enumerate(fmu.variables, 1) if v.port.causality == "output"]
    for tag in ("Outputs", "InitialUnknowns") if outputs else ():
        unknowns = ET.SubElement(structure, tag)
        unknowns.extend(ET.Element("Unknown", index=str(index)) for index in outputs)
    return structure
