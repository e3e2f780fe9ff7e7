"""Writer of functions of coordinates in OpenSim."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree import ElementTree

from ....model.function import Function, PiecewiseLinear, Polynomial
from ...writing.xml_text import element, numbers


def is_linear(function: Function) -> bool:
    """Return whether the function is constant or linear."""
    return isinstance(function, Polynomial) and len(function.coefficients) <= 2


def can_write_sum(functions: Sequence[Function]) -> bool:
    """Return whether OpenSim can hold a sum of functions: a single one, or linear ones."""
    return len(functions) == 1 or all(map(is_linear, functions))


def add_function(parent: ElementTree.Element, functions: Sequence[Function]) -> None:
    """Add a sum of functions that satisfies `can_write_sum`, in the order of their coordinates."""
    if len(functions) > 1:
        ends = [(*f.coefficients, 0.0)[:2] for f in functions if isinstance(f, Polynomial)]
        node = element(parent, "LinearFunction")
        slopes = [slope for _, slope in ends]
        element(node, "coefficients", numbers([*slopes, sum(offset for offset, _ in ends)]))
        return
    (function,) = functions
    if isinstance(function, Polynomial):
        _polynomial(parent, function.coefficients)
        return
    lines = isinstance(function, PiecewiseLinear)
    node = element(parent, "PiecewiseLinearFunction" if lines else "SimmSpline")
    element(node, "x", numbers(function.x))
    element(node, "y", numbers(function.y))


def _polynomial(parent: ElementTree.Element, coefficients: Sequence[float]) -> None:
    """Add a polynomial; in OpenSim the highest power comes first."""
    if len(coefficients) == 1:
        element(element(parent, "Constant"), "value", coefficients[0])
        return
    node = element(parent, "LinearFunction" if len(coefficients) == 2 else "PolynomialFunction")
    element(node, "coefficients", numbers(reversed(coefficients)))
