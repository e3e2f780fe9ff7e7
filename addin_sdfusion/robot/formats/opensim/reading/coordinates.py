"""Reader of OpenSim coordinates: ranges, locks and couplings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, cast

from ....finding_builders import unknown
from ....model.function import scaled
from ....model.joint import Coordinate, Joint, Term
from ...reading.xml import Node
from .document import inner_element, is_true, last_part, text
from .functions import read_terms

COUPLER = "CoordinateCouplerConstraint"
UNLIMITED = (-math.inf, math.inf)


def read_coordinate(node: Node, unit: str) -> Coordinate:
    """Return a coordinate; its range becomes joint limits if it is clamped."""
    node = node.named("coordinate")
    lower, upper = -math.inf, math.inf
    child = node.optional("range")
    if child is not None and is_true(node, "clamped", False):
        lower, upper = child.numbers(2, infinite=True)
    if is_true(node, "prescribed", False):
        problem = "its prescribed motion is ignored; it moves freely here"
        node.warning("prescribed-left-out", problem)
    if node.number("default_speed_value", 0.0):
        node.warning("speed-left-out", "its default speed is omitted; it starts at rest")
    return Coordinate(
        node.subject.name,
        lower,
        upper,
        node.number("default_value", 0.0),
        unit=cast(Literal["rad", "m"], unit),
        locked=is_true(node, "locked", False),
    )


def coordinate_ranges(nodes: Sequence[Node]) -> dict[str, tuple[float, float]]:
    """Return the range of each coordinate by name, clamped or not, in [rad] or [m]."""
    ranges = {}
    for node in nodes:
        child = node.optional("range")
        low, high = UNLIMITED if child is None else child.numbers(2, infinite=True)
        ranges[node.attribute("name", "")] = (low, high)
    return ranges


def with_couplings(joints: Sequence[Joint], constraints: Sequence[Node]) -> list[Joint]:
    """Return the joints with the couplings of couplers."""
    coordinates = {c.name: c for joint in joints for c in joint.coordinates}
    for node in constraints:
        if node.tag == COUPLER and is_true(node, "isEnforced", True):
            _couple(node, coordinates)
    return [joint.map_coordinates(lambda c: coordinates[c.name]) for joint in joints]


def _couple(node: Node, coordinates: dict[str, Coordinate]) -> None:
    dependent = last_part(text(node, "dependent_coordinate_name"))
    names = [last_part(word) for word in text(node, "independent_coordinate_names").split()]
    for name in (dependent, *names):
        if name not in coordinates:
            problem = f"<{COUPLER}>: {unknown('coordinate', name, list(coordinates))}"
            node.error("unknown-coordinate", problem)
            return
    function = inner_element(node, "coupled_coordinates_function")
    if function is None:
        node.error("missing-element", f"<{COUPLER}> has no function")
        return
    factor = node.number("scale_factor", 1.0)
    terms = tuple(
        Term(name or names[0], scaled(f, factor)) for name, f in read_terms(function, names)
    )
    coordinate = coordinates[dependent]
    if coordinate.locked or coordinate.coupling:
        state = "locked" if coordinate.locked else "coupled by an earlier one"
        node.warning(
            "coupler-left-out", f"{dependent!r} is already {state}; this coupler is omitted"
        )
        return
    lower, upper = -math.inf, math.inf  # the limits of the leading coordinates apply
    coordinates[dependent] = replace(coordinate, lower=lower, upper=upper, coupling=terms)
