"""Numeric variables of an FMU as arrays with fixed buffers."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cardsflow_fmu.cosim.signals.units import KNOWN_UNITS, Unit, variable_units
from cardsflow_fmu.cosim.signals.variables import ELEMENTS, ELEMENTS_FILE
from cardsflow_fmu.utils.arrays import FloatArray

_INTEGERS = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
_FUNCTIONS: dict[str, dict[str, str]] = {
    "2.0": {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"},
    "3.0": {t: t for t in ("Float64", "Float32", *_INTEGERS, "Boolean")} | {"Enumeration": "Int64"},
}
"""Type in the names of FMI functions by type of variable, in FMI 3.0 in the order of `fmu_type` in
csrc/fmu_step.h."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Numeric variable of an FMU.

    Attributes:
        function: Type in the names of FMI functions, such as `Real` or `Float64`.
        names: Names of the elements, or the name of the variable for a scalar.
        units: Units by element name.
        causality: Causality in the model description.
        start: Start values, or zero if the FMU specifies none.
    """

    function: str
    reference: int
    names: tuple[str, ...]
    units: Mapping[str, Unit]
    causality: str
    start: tuple[float, ...]


def read_signals(description: Any, folder: Path) -> list[Signal]:
    """Read the numeric variables of an unpacked FMU, in the order of its model description."""
    units = variable_units(description)
    functions = _FUNCTIONS[description.fmiVersion[:3]]
    elements = _elements(folder) if description.fmiVersion.startswith("3") else {}
    return [
        _signal(variable, functions[variable.type], elements.get(variable.name), units)
        for variable in description.modelVariables
        if variable.type in functions
    ]


def _signal(
    variable: Any,
    function: str,
    elements: list[dict[str, str]] | None,
    units: Mapping[str, Unit],
) -> Signal:
    shape = tuple(variable.shape or ())
    size = math.prod(shape)
    names = _element_names(variable.name, shape)
    units_of = {}
    if elements is not None and len(elements) == size:
        names = tuple(element["name"] for element in elements)
        units_of = {e["name"]: KNOWN_UNITS[e["unit"]] for e in elements if e["unit"] in KNOWN_UNITS}
    if variable.name in units:
        units_of = dict.fromkeys(names, units[variable.name])
    causality, start = variable.causality or "local", _start(variable.start, size)
    return Signal(function, variable.valueReference, names, units_of, causality, start)


def _element_names(name: str, shape: tuple[int, ...]) -> tuple[str, ...]:
    """Return `q[1]`, `q[2]`, ... for an array `q`, in the order of FMI's values."""
    if not shape:
        return (name,)
    indices = product(*(range(1, size + 1) for size in shape))
    return tuple(f"{name}[{','.join(map(str, index))}]" for index in indices)


def _start(text: str | None, size: int) -> tuple[float, ...]:
    words = (text or "").split()
    values = [{"true": 1.0, "false": 0.0}.get(word) for word in words]
    numbers = [
        float(word) if value is None else value for word, value in zip(words, values, strict=True)
    ]
    if len(numbers) == 1:
        numbers *= size
    return tuple(numbers) if len(numbers) == size else (0.0,) * size


def _elements(folder: Path) -> dict[str, list[dict[str, str]]]:
    """Read names and units of array elements, by the array's name.

    They are in a file or in annotations.
    """
    file = folder / ELEMENTS_FILE
    if file.is_file():
        arrays = dict(json.loads(file.read_text("utf-8")))
        return {name: _element_texts(rows) for name, rows in arrays.items()}
    root = ET.parse(folder / "modelDescription.xml").getroot()  # FMPy has already checked it
    elements = {}
    for variable in root.iterfind("ModelVariables/*"):
        for annotation in variable.iterfind(f"Annotations/Annotation[@type='{ELEMENTS}']"):
            elements[variable.get("name", "")] = _element_texts(json.loads(annotation.text or "[]"))
    return elements


def _element_texts(rows: Any) -> list[dict[str, str]]:
    return [{key: str(row[key]) for key in ("name", "unit")} for row in rows]


def type_number(version: int, function: str) -> int:
    """Return the number of a type in `fmu_type`, by its name in FMI functions."""
    if version == 2:
        return {"Real": 0, "Integer": 6, "Boolean": 11}[function]
    return list(_FUNCTIONS["3.0"]).index(function)


class Bank(NamedTuple):
    """Variables of one type, adjacent in a row."""

    function: str
    references: tuple[int, ...]
    place: slice


class Row:
    """Signals of an FMU in one array.

    Attributes:
        values: Values, shape (len(names),); initially the start values.
        banks: Variables by type, in the order of the values.
    """

    def __init__(self, signals: Sequence[Signal]) -> None:
        functions = dict.fromkeys(signal.function for signal in signals)
        ordered = [[s for s in signals if s.function == function] for function in functions]
        flat = [signal for group in ordered for signal in group]
        self.names = tuple(name for signal in flat for name in signal.names)
        self.values: FloatArray = np.array([v for signal in flat for v in signal.start], float)
        self.banks: list[Bank] = []
        begin = 0
        for group in ordered:
            end = begin + sum(len(signal.names) for signal in group)
            if end > begin:
                references = tuple(signal.reference for signal in group)
                place = slice(begin, end)
                self.banks.append(Bank(group[0].function, references, place))
            begin = end
