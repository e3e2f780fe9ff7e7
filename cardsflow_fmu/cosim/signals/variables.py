"""Variables of FMUs: scalars, or arrays of adjacent ports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from .ports import Port

ELEMENTS = "org.cardsflow.elements"
"""Type of an annotation that lists names and units of the elements of an array as JSON."""
ELEMENTS_FILE = "extra/org.cardsflow/elements.json"
"""File of an FMU with such a list for each array. FMI Library skips the dimensions of variables
with annotations; therefore, FMUs of this package contain this file instead."""


@dataclass(frozen=True, slots=True)
class Variable:
    """Variable of an FMU, a scalar or an array.

    Attributes:
        name: Name, such as `q.elbow`, or `q` for an array.
        reference: Value reference: index of the first port in the table of the model.
        ports: The port of a scalar, or the elements of an array.
        is_array: Whether the variable is an array, which may have a single element.
    """

    name: str
    reference: int
    ports: tuple[Port, ...]
    is_array: bool = False

    @property
    def port(self) -> Port:
        """First port. All ports have the same causality, variability and type."""
        return self.ports[0]

    @property
    def unit(self) -> str:
        """Common unit of the elements, `1` for numbers, or empty for booleans and mixed units."""
        units = {port.unit or "1" for port in self.ports}
        return units.pop() if len(units) == 1 and not self.port.boolean else ""

    @property
    def description(self) -> str:
        """Description in one line, which names the elements of an array."""
        if not self.is_array:
            return self.port.description
        units = "" if len({port.unit for port in self.ports}) == 1 else " (units differ)"
        names = ", ".join(port.name.split(".", 1)[1].rstrip(")") for port in self.ports)
        return f"{_common_description(self.ports)} of {names}{units}"


def scalar_variables(ports: Sequence[Port]) -> list[Variable]:
    """Return one variable per port."""
    return [Variable(port.name, index, (port,)) for index, port in enumerate(ports)]


def array_variables(ports: Sequence[Port]) -> list[Variable]:
    """Combine adjacent ports with a common prefix to arrays, such as `q.a` and `q.b` to `q`."""
    variables: list[Variable] = []
    reference = 0
    for key, group in groupby(ports, _array_key):
        members = tuple(group)
        if key[0]:
            variables.append(Variable(key[0], reference, members, is_array=True))
        else:
            variables += [
                Variable(port.name, reference + k, (port,)) for k, port in enumerate(members)
            ]
        reference += len(members)
    return variables


def _array_key(port: Port) -> tuple[str, str, str, bool]:
    """Return the key of a port's array. The name in the key is empty for a scalar."""
    prefix, dot, _ = port.name.partition(".")
    if prefix.startswith("der("):
        prefix += ")"
    return prefix if dot else "", port.causality, port.variability, port.boolean


def _common_description(ports: Sequence[Port]) -> str:
    """Return the common beginning of descriptions.

    For `Force of muscle a` and `Force of muscle b` it is `Force`.
    """
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
