"""The node of an address."""

from __future__ import annotations

from .address import NodeAddress
from .node import Node


def open_node(address: NodeAddress) -> Node:
    """Open a node; it leaves the graph at its end, as a context.

    Raises:
        InputError: A package of its extra is missing, or its middleware cannot be reached.
    """
    if address.middleware == "dds":
        from .dds_node import DdsNode

        return DdsNode(address)
    from .zenoh_node import ZenohNode

    return ZenohNode(address)
