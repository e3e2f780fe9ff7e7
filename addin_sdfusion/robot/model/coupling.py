"""Values of all coordinates, including coupled and locked ones, from the free ones."""

from __future__ import annotations

from collections.abc import Mapping

from .function import value
from .joint import Coordinate
from .robot import Robot


def followers(robot: Robot) -> list[Coordinate]:
    """Return the coupled coordinates, each after the coordinates that it follows.

    Args:
        robot: A robot without cyclic couplings.
    """
    coupled = {c.name: c for c in robot.all_coordinates if c.coupling and not c.locked}
    ordered: dict[str, Coordinate] = {}
    waiting = [*reversed(coupled.values())]
    while waiting:
        c = waiting[-1]
        before = [t.coordinate for t in c.coupling if t.coordinate in coupled]
        missing = [coupled[name] for name in before if name not in ordered]
        waiting += missing
        if not missing:
            ordered.setdefault(waiting.pop().name, c)
    return list(ordered.values())


def all_values(robot: Robot, q: Mapping[str, float]) -> dict[str, float]:
    """Return the value of every coordinate, in [rad] or [m].

    Args:
        robot: A valid robot.
        q: Values of the free coordinates, by name.
    """
    values = {c.name: c.initial for c in robot.all_coordinates if c.locked} | dict(q)
    for c in followers(robot):
        values[c.name] = sum(value(term.function, values[term.coordinate]) for term in c.coupling)
    return values
