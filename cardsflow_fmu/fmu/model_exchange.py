"""Parts of model descriptions for model exchange: states and structure."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from cardsflow_fmu.cosim.signals.continuous import state_signal
from cardsflow_fmu.cosim.signals.variables import Variable

from .description import FmuDescription

_EVENT = "event."
_IMPULSES = ("q", "qd")  # states that events change


def indicators(fmu: FmuDescription) -> list[Variable]:
    """Return the event indicators; one variable in case of arrays."""
    return [v for v in fmu.variables if v.name.startswith(_EVENT) or v.name == _EVENT[:-1]]


def mark_states(fmu: FmuDescription, elements: Sequence[ET.Element], first: int = 0) -> None:
    """Set the attributes of states and derivatives.

    Args:
        fmu: The FMU.
        elements: The element with the attributes of each variable.
        first: Index of the first variable; 0 for value references.
    """
    names = {variable.name: index for index, variable in enumerate(fmu.variables)}
    for variable, element in zip(fmu.variables, elements, strict=True):
        element.attrib.pop("intermediateUpdate", None)
        state = state_signal(variable.name)
        if state is None:
            continue
        at = names[state]
        place = at + first if first else fmu.variables[at].reference
        element.set("derivative", str(place))
        if state.partition(".")[0] in _IMPULSES:
            elements[at].set("reinit", "true")


def structure_2(fmu: FmuDescription, steps: ET.Element) -> ET.Element:
    """Return the element `ModelStructure` of FMI 2.0.

    Args:
        fmu: The FMU.
        steps: The structure for co-simulation.
    """
    structure = ET.Element("ModelStructure")
    places = {variable.name: index for index, variable in enumerate(fmu.variables, 1)}
    outputs = ET.SubElement(structure, "Outputs")
    for variable in fmu.variables:
        if variable.port.causality == "output":
            _unknown(outputs, "Unknown", "index", places, variable.name, _known(fmu, variable))
    derivatives = ET.SubElement(structure, "Derivatives")
    for variable in _derivatives(fmu):
        _unknown(derivatives, "Unknown", "index", places, variable.name, _known(fmu, variable))
    initial = steps.find("InitialUnknowns")
    if initial is not None:
        structure.append(initial)
        for variable in _derivatives(fmu):
            _unknown(initial, "Unknown", "index", places, variable.name, None)
    return structure


def structure_3(fmu: FmuDescription, steps: ET.Element) -> ET.Element:
    """Return the element `ModelStructure` of FMI 3.0.

    Args:
        fmu: The FMU.
        steps: The structure for co-simulation.
    """
    structure = ET.Element("ModelStructure")
    places = {variable.name: variable.reference for variable in fmu.variables}
    attribute = "valueReference"
    for variable in fmu.variables:
        if variable.port.causality == "output":
            known = _known(fmu, variable)
            _unknown(structure, "Output", attribute, places, variable.name, known)
    for variable in _derivatives(fmu):
        known = _known(fmu, variable)
        _unknown(structure, "ContinuousStateDerivative", attribute, places, variable.name, known)
    structure.extend(steps.findall("InitialUnknown"))
    for variable in _derivatives(fmu):
        _unknown(structure, "InitialUnknown", attribute, places, variable.name, None)
    for variable in indicators(fmu):
        _unknown(structure, "EventIndicator", attribute, places, variable.name, None)
    return structure


def _derivatives(fmu: FmuDescription) -> list[Variable]:
    return [v for v in fmu.variables if state_signal(v.name) is not None]


def _known(fmu: FmuDescription, variable: Variable) -> str | None:
    """Return the only variable that an output or a derivative depends on, or None for several."""
    state = state_signal(variable.name)
    if state is None:
        states = {state_signal(other.name) for other in fmu.variables}
        return variable.name if variable.name in states else None
    prefix, _, thing = state.partition(".")
    if prefix != "q":
        return None
    return f"qd.{thing}" if thing else "qd"


def _unknown(
    parent: ET.Element,
    tag: str,
    attribute: str,
    places: dict[str, int],
    name: str,
    known: str | None,
) -> None:
    """Add an unknown. Without a single known it depends on all states and inputs."""
    element = ET.SubElement(parent, tag, {attribute: str(places[name])})
    if known is not None:
        element.set("dependencies", str(places[known]))
