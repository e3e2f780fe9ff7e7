"""Reader of functions of coordinates in .osim files."""

from __future__ import annotations

from collections.abc import Sequence

from ....model.function import (
    Function,
    PiecewiseLinear,
    Polynomial,
    SimmSpline,
    constant,
    linear,
    scaled,
)
from ...reading.xml import Node
from .document import inner_element

Terms = list[tuple[str, Function]]
"""A sum of terms: name of a coordinate and function; the name is empty for a constant."""
SUPPORTED = (
    "Constant",
    "LinearFunction",
    "MultiplierFunction",
    "PiecewiseLinearFunction",
    "PolynomialFunction",
    "SimmSpline",
)
POINTS: dict[str, type[SimmSpline] | type[PiecewiseLinear]] = {
    "SimmSpline": SimmSpline,
    "PiecewiseLinearFunction": PiecewiseLinear,
}
MAX_INNER = 20
MIN_INTERVAL = 1e-7
"""Smallest distance of two points in x, as in OpenSim's SimmSpline."""


def read_terms(node: Node, coordinates: Sequence[str], depth: int = 0) -> Terms:
    """Return a function of coordinates as a sum; report unsupported functions as errors.

    Args:
        coordinates: Names of the coordinates that it depends on.
        depth: Number of functions that contain it.
    """
    if node.tag == "Constant":
        return [("", constant(node.number("value", 0.0)))]
    if node.tag == "MultiplierFunction" and depth < MAX_INNER:
        factor, of = node.number("scale", 1.0), inner_element(node, "function")
        terms = [] if of is None else read_terms(of, coordinates, depth + 1)
        return [(name, scaled(function, factor)) for name, function in terms]
    if node.tag not in SUPPORTED or not coordinates:
        problem = f"<{node.tag}> of {len(coordinates)} coordinates is not supported"
        node.error("unsupported-function", problem, SUPPORTED)
        return []
    if node.tag == "LinearFunction":
        return _linear(node, coordinates)
    if len(coordinates) != 1:
        node.error("unsupported-function", f"<{node.tag}> is a function of one coordinate only")
    if node.tag == "PolynomialFunction":
        highest_first = _numbers(node, "coefficients")
        return [(coordinates[0], Polynomial(tuple(reversed(highest_first)) or (0.0,)))]
    x, y = _increasing(node, _numbers(node, "x")), _numbers(node, "y")
    if len(x) == 1 == len(y):
        return [("", constant(y[0]))]
    return [(coordinates[0], POINTS[node.tag](x, y))]


def _increasing(node: Node, x: tuple[float, ...]) -> tuple[float, ...]:
    """Move repeated values by `MIN_INTERVAL`: OpenSim computes slopes with this distance."""
    moved = list(x)
    for k in range(1, len(x)):
        if x[k] == x[k - 1]:
            moved[k] = moved[k - 1] + MIN_INTERVAL
            name = node.attribute("name", "") or node.tag
            node.warning(
                "repeated-x",
                f"function {name!r} has x = {x[k]:g} twice; the second point is moved by "
                f"{MIN_INTERVAL:g}, which gives OpenSim's slopes",
            )
    return tuple(moved)


def _linear(node: Node, coordinates: Sequence[str]) -> Terms:
    """Return the terms of a_1 x_1 + a_2 x_2 + ... + b."""
    values = _numbers(node, "coefficients") or (1.0, 0.0)
    if len(values) != len(coordinates) + 1:
        problem = f"must have {len(coordinates) + 1} coefficients, not {len(values)}"
        node.error("bad-vector", problem)
        return []
    *slopes, offset = values
    return [
        (name, linear(slope, offset if k == 0 else 0.0))
        for k, (name, slope) in enumerate(zip(coordinates, slopes, strict=True))
    ]


def _numbers(node: Node, tag: str) -> tuple[float, ...]:
    child = node.optional(tag)
    return () if child is None else child.numbers(len(child.text.split()))
