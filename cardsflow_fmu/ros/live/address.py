"""Addresses of nodes: ros2://HOST:PORT/NAMESPACE?domain=N&node=NAME."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

from addin_sdfusion.robot import InputError, UnknownNameError

SCHEME = "ros2"
_PORT = 7447  # of rmw_zenoh's router
_MOST_DOMAIN = 232
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KEYS = ("domain", "node")


@dataclass(frozen=True, slots=True)
class NodeAddress:
    """Where a node is, and what it is called.

    Attributes:
        host, port: Of the router of rmw_zenoh.
        domain: Number of the ROS domain.
        namespace: Of the node, with a slash before every part; empty for none.
        node: Its name.
    """

    host: str = "localhost"
    port: int = _PORT
    domain: int = 0
    namespace: str = ""
    node: str = "cardsflow"

    @property
    def router(self) -> str:
        """The router's address as zenoh has it."""
        return f"tcp/{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"

    def __str__(self) -> str:
        return (
            f"{self.namespace}/{self.node} in domain {self.domain}, over the router {self.router}"
        )

    def absolute(self, topic: str) -> str:
        """A topic of the node by its whole name; `/clock` and `/tf` are those of all."""
        return topic if topic in ("/clock", "/tf") else f"{self.namespace}{topic}"


def node_address(uri: str) -> NodeAddress:
    """Read an address.

    Args:
        uri: `ros2://`, with what differs from the defaults: localhost, 7447, no namespace,
            the domain of the environment variable ROS_DOMAIN_ID or 0, node `cardsflow`.

    Raises:
        InputError: It is no such address.
    """
    try:
        parts = urlsplit(uri)
        port = parts.port
    except ValueError:
        raise InputError(f"{uri!r} is no address; give ros2://HOST:PORT") from None
    if parts.scheme != SCHEME or parts.username or parts.fragment:
        raise InputError(f"{uri!r} is no address of ROS 2; give ros2://HOST:PORT")
    given = dict(parse_qsl(parts.query, keep_blank_values=True))
    for key in given:
        if key not in _KEYS:
            raise UnknownNameError("option", key, _KEYS, key=uri)
    names = [name for name in parts.path.split("/") if name]
    node = given.get("node", "cardsflow")
    for name in (*names, node):
        if not _NAME.fullmatch(name):
            raise InputError(f"{name!r} is no name of ROS: letters, digits, underscores", key=uri)
    domain = given.get("domain", os.environ.get("ROS_DOMAIN_ID") or "0")
    if not (domain.isascii() and domain.isdigit() and int(domain) <= _MOST_DOMAIN):
        raise InputError(f"the domain must be 0 to {_MOST_DOMAIN}, not {domain!r}", key=uri)
    namespace = "".join(f"/{name}" for name in names)
    host = parts.hostname or "localhost"
    return NodeAddress(host, port or _PORT, int(domain), namespace, node)
