"""States and unknowns of a model, and the variables that unknowns depend on."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Literal, NamedTuple

from cardsflow_fmu.cosim.signals.continuous import state_signal
from cardsflow_fmu.cosim.signals.variables import Variable

from .description import FmuDescription

Kind = Literal["output", "derivative", "initial", "indicator"]

_EVENT = "event."
_INPUTS = ("input", "parameter")
_IMPULSES = ("q", "qd")  # states that events change


class Unknown(NamedTuple):
    """Unknown of a model.

    Attributes:
        kind: Output or derivative of a state; output or derivative at the start; event indicator.
        knowns: Variables that it depends on, in order; None for all.
    """

    kind: Kind
    variable: Variable
    knowns: list[Variable] | None


def unknowns_of(fmu: FmuDescription, causalities: Collection[str] = _INPUTS) -> list[Unknown]:
    """Return the unknowns in the order of the standard.

    Outputs of co-simulation depend on inputs and tunable parameters over a step. In continuous
    time, outputs and derivatives depend on states and inputs. At the start, outputs depend on
    inputs and parameters.

    Args:
        causalities: Causalities of the variables on which outputs may depend over a step.
    """
    outputs = [v for v in fmu.variables if v.port.causality == "output"]
    initial = [Unknown("initial", v, _inputs_of(fmu, v, _INPUTS, at_start=True)) for v in outputs]
    if not fmu.is_continuous:
        direct = (_inputs_of(fmu, v, causalities, at_start=False) for v in outputs)
        return [Unknown("output", v, k) for v, k in zip(outputs, direct, strict=True)] + initial
    derivatives = [v for v in fmu.variables if state_signal(v.name) is not None]
    return [
        *(Unknown("output", v, _states_of(fmu, v)) for v in outputs),
        *(Unknown("derivative", v, _states_of(fmu, v)) for v in derivatives),
        *initial,
        *(Unknown("initial", v, None) for v in derivatives),
        *(Unknown("indicator", v, None) for v in indicators(fmu)),
    ]


def indicators(fmu: FmuDescription) -> list[Variable]:
    """Return the event indicators; one variable in case of arrays."""
    return [v for v in fmu.variables if v.name.startswith(_EVENT) or v.name == _EVENT[:-1]]


def mark_states(fmu: FmuDescription, elements: Sequence[ET.Element], first: int = 0) -> None:
    """Set the attributes of states and derivatives.

    Args:
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


def add_unknowns(
    parent: ET.Element,
    unknowns: Iterable[Unknown],
    tag: Callable[[Unknown], str],
    attribute: str,
    place: Callable[[Variable], int],
) -> None:
    """Add an element for each unknown."""
    for unknown in unknowns:
        element = ET.SubElement(parent, tag(unknown), {attribute: str(place(unknown.variable))})
        if unknown.knowns is not None:
            element.set("dependencies", " ".join(str(place(known)) for known in unknown.knowns))


def _inputs_of(
    fmu: FmuDescription, output: Variable, causalities: Collection[str], *, at_start: bool
) -> list[Variable] | None:
    """Return the inputs and parameters that an output depends on; None if unknown."""
    if fmu.dependencies is None:
        return None
    dependencies = fmu.dependencies.at_start if at_start else fmu.dependencies.direct
    names = frozenset[str]().union(*(dependencies[port.name] for port in output.ports))
    return [
        variable
        for variable in fmu.variables
        if variable.port.causality in causalities
        and any(port.name in names for port in variable.ports)
    ]


def _states_of(fmu: FmuDescription, variable: Variable) -> list[Variable] | None:
    """Return the state that is an output, or the velocity that is a derivative; else None."""
    state = state_signal(variable.name)
    if state is None:
        states = {state_signal(other.name) for other in fmu.variables}
        return [variable] if variable.name in states else None
    prefix, _, joint = state.partition(".")
    if prefix != "q":
        return None
    velocity = f"qd.{joint}" if joint else "qd"
    return [other for other in fmu.variables if other.name == velocity]
