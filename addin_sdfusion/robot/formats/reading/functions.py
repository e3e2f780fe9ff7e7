"""Reader of functions of coordinates in the SDF plugin."""

from __future__ import annotations

from ...model.function import ITSELF, Function, Polynomial
from ..writing.functions import POINT_KINDS, POLYNOMIAL
from .xml import Node, short_repr


def read_function(node: Node) -> Function:
    """Return the function that an element defines; the identity if it has no kind."""
    kind = node.attribute("kind", "")
    if not kind:
        return ITSELF
    if kind == POLYNOMIAL:
        return Polynomial(node.numbers(len(node.text.split())))
    if kind not in POINT_KINDS:
        choices = (POLYNOMIAL, *POINT_KINDS)
        node.error("unsupported-function", f"unknown kind {short_repr(kind)}", choices)
        return ITSELF
    x, y = (
        node.numbers_attribute(name, len(node.attribute(name, "").split())) for name in ("x", "y")
    )
    return POINT_KINDS[kind](x, y)
