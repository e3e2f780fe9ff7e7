"""Model descriptions of FMI 3.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.variables import Variable

from .description import (
    FmuDescription,
    display_unit,
    document,
    format_flag,
    format_number,
    format_start,
    number_attributes,
    type_names,
)
from .structure import add_unknowns, mark_states, unknowns_of

_TIME = "time"
_UNKNOWNS = {
    "output": "Output",
    "derivative": "ContinuousStateDerivative",
    "initial": "InitialUnknown",
    "indicator": "EventIndicator",
}


def describe(fmu: FmuDescription, token: str) -> ET.Element:
    """Return the root element of a model description of FMI 3.0.

    Raises:
        InputError: A variable has the name of the independent variable.
    """
    if _TIME in {variable.name for variable in fmu.variables}:
        raise InputError(f"the name {_TIME!r} is reserved for the independent variable of FMI 3.0")
    types = type_names(fmu)
    variables = [_variable(variable, types) for variable in fmu.variables]
    if fmu.is_continuous:
        mark_states(fmu, variables)
    return document(
        fmu,
        {"fmiVersion": "3.0", "instantiationToken": token},
        _model_exchange(fmu) if fmu.is_continuous else _co_simulation(fmu),
        (
            ET.Element("Float64Type", display_unit(unit), name=n, quantity=n, unit=unit)
            for unit, n in types.items()
        ),
        [*variables, _independent(len(fmu.ports))],
        _model_structure(fmu),
    )


def _co_simulation(fmu: FmuDescription) -> ET.Element:
    element = _interface(
        "CoSimulation",
        fmu,
        canHandleVariableCommunicationStepSize=format_flag(fmu.any_step),
        providesIntermediateUpdate="true",
        canReturnEarlyAfterIntermediateUpdate=format_flag(fmu.returns_early),
        hasEventMode="false",
    )
    if fmu.internal_step is not None:
        element.set("fixedInternalStepSize", format_number(fmu.internal_step))
    return element


def _model_exchange(fmu: FmuDescription) -> ET.Element:
    return _interface(
        "ModelExchange",
        fmu,
        needsCompletedIntegratorStep="true",
        providesEvaluateDiscreteStates="false",
    )


def _interface(kind: str, fmu: FmuDescription, **more: str) -> ET.Element:
    """Return the element of an interface, with the attributes of both kinds and with more."""
    return ET.Element(
        kind,
        more,
        modelIdentifier=fmu.model_name,
        needsExecutionTool=format_flag(fmu.needs_tool),
        canBeInstantiatedOnlyOncePerProcess="false",
        canGetAndSetFMUState=format_flag(fmu.has_state),
        canSerializeFMUState=format_flag(fmu.has_state),
        providesDirectionalDerivatives=format_flag(fmu.has_derivatives),
    )


def _variable(variable: Variable, types: dict[str, str]) -> ET.Element:
    port = variable.port
    element = ET.Element(
        "Boolean" if port.boolean else "Float64",
        number_attributes(variable, types),
        name=variable.name,
        valueReference=str(variable.reference),
        description=variable.description,
        causality=port.causality,
        variability=port.variability,
    )
    if port.causality in ("output", "local"):
        element.set("initial", "calculated")
        element.set("intermediateUpdate", "true")
    else:
        element.set("start", " ".join(map(format_start, variable.ports)))
    if variable.is_array:
        ET.SubElement(element, "Dimension", start=str(len(variable.ports)))
    return element


def _independent(reference: int) -> ET.Element:
    return ET.Element(
        "Float64",
        name=_TIME,
        valueReference=str(reference),
        description="Simulation time",
        causality="independent",
        variability="continuous",
    )


def _model_structure(fmu: FmuDescription) -> ET.Element:
    structure = ET.Element("ModelStructure")
    add_unknowns(
        structure,
        unknowns_of(fmu),
        lambda unknown: _UNKNOWNS[unknown.kind],
        "valueReference",
        lambda variable: variable.reference,
    )
    return structure
