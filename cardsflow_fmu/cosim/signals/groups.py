"""Named groups of variables, and the positions of the groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .port import Port

Groups = Mapping[str, Sequence[Port]]
"""Variables of a model by the name of their group, in the order of the table."""


def all_ports(groups: Groups) -> list[Port]:
    """Return the variables in order."""
    return [port for ports in groups.values() for port in ports]


def group_slices(groups: Groups) -> dict[str, slice]:
    """Return the position of each group in the table."""
    places, first = {}, 0
    for name, ports in groups.items():
        places[name] = slice(first, first + len(ports))
        first += len(ports)
    return places
