"""Variables of FMUs: scalars, or arrays of neighbouring ports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from .ports import Port

ELEMENTS = "org.cardsflow.elements"
"""Type of the annotation with name and unit of the elements of an array, as a JSON list."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of an FMU.

    Attributes:
        name: Such as `q.elbow`, or `q` for an array.
        reference: The value reference: the index of its first port in the model's table.
        ports: One port, or, for an array, its elements.
        is_array: Whether it is an array, which may have a single element.
    """

    name: str
    reference: int
    ports: tuple[Port, ...]
    is_array: bool = False

    @property
    def port(self) -> Port:
        """The first port: all have the same causality, variability and type."""
        return self.ports[0]

    @property
    def unit(self) -> str:
        """The unit that all elements have, `1` for numbers; empty where they have different ones.

        A truth value has none.
        """
        units = {port.unit or "1" for port in self.ports}
        return units.pop() if len(units) == 1 and not self.port.boolean else ""

    @property
    def description(self) -> str:
        """One line for people; of an array, what its elements are."""
        if not self.is_array:
            return self.port.description
        units = "" if len({port.unit for port in self.ports}) == 1 else " (units differ)"
        names = ", ".join(port.name.split(".", 1)[1] for port in self.ports)
        return f"{_common(self.ports)} of {names}{units}"


def scalar_variables(ports: Sequence[Port]) -> list[Variable]:
    """One variable a port."""
    return [Variable(port.name, index, (port,)) for index, port in enumerate(ports)]


def array_variables(ports: Sequence[Port]) -> list[Variable]:
    """Neighbours with a common first part of their names as arrays: `q.a`, `q.b` as `q`."""
    variables: list[Variable] = []
    reference = 0
    for key, group in groupby(ports, _array):
        members = tuple(group)
        if key[0]:
            variables.append(Variable(key[0], reference, members, is_array=True))
        else:
            variables += [
                Variable(port.name, reference + k, (port,)) for k, port in enumerate(members)
            ]
        reference += len(members)
    return variables


def _array(port: Port) -> tuple[str, str, str, bool]:
    """Key of the array of a port; with an empty name for a port on its own."""
    prefix, dot, _ = port.name.partition(".")
    return prefix if dot else "", port.causality, port.variability, port.boolean


def _common(ports: Sequence[Port]) -> str:
    """The common beginning of ports' descriptions: `Force` for `Force of muscle a`, `.. of b`."""
    words = [port.description.split() for port in ports]
    shared = []
    for column in zip(*words, strict=False):
        if len(set(column)) > 1:
            break
        shared.append(column[0])
    if len(ports) == 1 and shared:
        shared = shared[: shared.index("of")] if "of" in shared else shared
    while shared and shared[-1] in ("of", "on", "muscle"):
        shared.pop()
    return " ".join(shared) or "Values"
