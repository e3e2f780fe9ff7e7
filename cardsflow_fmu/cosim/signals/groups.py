"""Tables of variables in named groups, and the places of these."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from cardsflow_fmu.utils.arrays import FloatArray

from .port import Port

Groups = Mapping[str, Sequence[Port]]
"""The variables of a model by the name of their group, in the order of the table."""


def all_ports(groups: Groups) -> list[Port]:
    """The table of variables."""
    return [port for ports in groups.values() for port in ports]


def group_places(groups: Groups) -> dict[str, slice]:
    """Where each group is in the table."""
    places, first = {}, 0
    for name, ports in groups.items():
        places[name] = slice(first, first + len(ports))
        first += len(ports)
    return places


def group_views(groups: Groups, values: FloatArray) -> dict[str, FloatArray]:
    """The values of each group.

    Args:
        groups: The table in groups.
        values: Of all its variables, in order.
    """
    return {name: values[place] for name, place in group_places(groups).items()}
