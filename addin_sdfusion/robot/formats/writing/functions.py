"""XML elements for functions of coordinates in the SDF plugin.

kind polynomial: coefficients as text, in ascending order. kind simm_spline or piecewise_linear: x
and y of the points as attributes. An element without a kind is the identity.
"""

from __future__ import annotations

from xml.etree import ElementTree

from ...model.function import ITSELF, Function, PiecewiseLinear, Polynomial, SimmSpline
from .xml_text import element, numbers

POLYNOMIAL = "polynomial"
POINT_KINDS: dict[str, type[SimmSpline | PiecewiseLinear]] = {
    "simm_spline": SimmSpline,
    "piecewise_linear": PiecewiseLinear,
}


def function_element(
    parent: ElementTree.Element, tag: str, function: Function, **attributes: str
) -> ElementTree.Element:
    """Add an element that holds a function and other attributes."""
    if function == ITSELF:
        return element(parent, tag, None, **attributes)
    if isinstance(function, Polynomial):
        text = numbers(function.coefficients)
        return element(parent, tag, text, **attributes, kind=POLYNOMIAL)
    kind = next(kind for kind, type_ in POINT_KINDS.items() if isinstance(function, type_))
    points = {"x": numbers(function.x), "y": numbers(function.y)}
    return element(parent, tag, None, **attributes, kind=kind, **points)
