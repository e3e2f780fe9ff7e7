"""Friction of joints that follow others by <mimic>."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...model.function import Polynomial
from ...model.joint import Coordinate, Joint
from ..reading.xml import Node


def with_leading_friction(joints: Sequence[Joint], node: Node) -> list[Joint]:
    """Return the joints with the friction of following joints on their leading joints.

    The dissipated power is the same: friction f of a joint that moves k times as fast as its
    leading joint equals friction |k| f of the leading joint.
    """
    coordinates = {c.name: c for joint in joints for c in joint.coordinates}
    friction = dict.fromkeys(coordinates, 0.0)
    moved = []
    for c in coordinates.values():
        leader, ratio = _leader(c, coordinates)
        friction[leader] += ratio * c.friction
        if leader != c.name and c.friction:
            moved.append(c.name)
    if not moved:
        return list(joints)
    names = ", ".join(map(repr, moved[:10]))
    problem = f"the friction of {names}, which follow others, is applied to the leading joints"
    node.warning("friction-of-mimic", problem)
    return [
        joint.map_coordinates(lambda c: replace(c, friction=friction[c.name])) for joint in joints
    ]


def _leader(coordinate: Coordinate, coordinates: dict[str, Coordinate]) -> tuple[str, float]:
    """Return the coordinate that drives one, and the magnitude of the ratio of their velocities.

    A coordinate that follows an unknown one, or itself, is its own leader.
    """
    ratio, at = 1.0, coordinate
    for _ in coordinates:
        if len(at.coupling) != 1:
            break
        (term,) = at.coupling
        if term.coordinate not in coordinates or not isinstance(term.function, Polynomial):
            return coordinate.name, 1.0
        ratio *= abs(term.function.coefficients[1])
        at = coordinates[term.coordinate]
    return (at.name, ratio) if not at.coupling else (coordinate.name, 1.0)
