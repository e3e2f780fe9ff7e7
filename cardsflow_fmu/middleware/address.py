"""Addresses of nodes: ros2://HOST:PORT/NAMESPACE?rmw=zenoh&domain=N&node=NAME."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from typing import Literal
from urllib.parse import parse_qsl, urlsplit

from addin_sdfusion.robot import InputError, UnknownNameError

SCHEME = "ros2"
FORM = "ros2://HOST:PORT/NAMESPACE?rmw=zenoh"
Middleware = Literal["zenoh", "dds"]

_PORT = 7447  # of rmw_zenoh's router
_MOST_DOMAIN = 232
_MOST_DEPTH = 1000
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KEYS = ("rmw", "domain", "node", "reliability", "depth", "timeout")
_MIDDLEWARE: dict[str, Middleware] = {
    "zenoh": "zenoh",
    "dds": "dds",
    "rmw_zenoh_cpp": "zenoh",
    "rmw_cyclonedds_cpp": "dds",
    "rmw_fastrtps_cpp": "dds",
}
_RELIABLE = {"reliable": True, "best_effort": False}


@dataclass(frozen=True, slots=True)
class NodeAddress:
    """Where a node is, and what it is called.

    Attributes:
        middleware: What carries its messages.
        host, port: Of the router of rmw_zenoh; with DDS the host is that of the only peer, and
            empty for all that DDS finds by itself.
        domain: Number of the ROS domain.
        namespace: Of the node, with a slash before every part; empty for none.
        node: Its name.
        reliable: Whether lost messages are sent again.
        depth: Messages that are kept for a subscriber.
        timeout: Longest silence where commands go by topics, in [s]; None where it is not stated.
    """

    middleware: Middleware = "zenoh"
    host: str = "localhost"
    port: int = _PORT
    domain: int = 0
    namespace: str = ""
    node: str = "cardsflow"
    reliable: bool = True
    depth: int = 10
    timeout: float | None = None

    @property
    def router(self) -> str:
        """The router's address as zenoh has it."""
        return f"tcp/{f'[{self.host}]' if ':' in self.host else self.host}:{self.port}"

    def __str__(self) -> str:
        how = f"the router {self.router}" if self.middleware == "zenoh" else "DDS"
        with_peer = f" with {self.host}" if self.middleware == "dds" and self.host else ""
        return f"{self.namespace}/{self.node} in domain {self.domain}, over {how}{with_peer}"

    def absolute(self, topic: str) -> str:
        """A topic of the node by its whole name; `/clock` and `/tf` are those of all."""
        return topic if topic in ("/clock", "/tf") else f"{self.namespace}{topic}"


def node_address(uri: str) -> NodeAddress:
    """Read an address.

    Args:
        uri: `ros2://`, with what differs from the defaults: localhost, 7447, no namespace, the
            middleware of the environment variable RMW_IMPLEMENTATION or zenoh, the domain of
            ROS_DOMAIN_ID or 0, node `cardsflow`, reliable with depth 10, no timeout.

    Raises:
        InputError: It is no such address.
    """
    try:
        parts = urlsplit(uri)
        port = parts.port
    except ValueError:
        raise InputError(f"{uri!r} is no address; give {FORM}") from None
    if parts.scheme != SCHEME or parts.username or parts.fragment:
        raise InputError(f"{uri!r} is no address of ROS 2; give {FORM}")
    given = dict(parse_qsl(parts.query, keep_blank_values=True))
    for key in given:
        if key not in _KEYS:
            raise UnknownNameError("option", key, _KEYS, key=uri)
    names = [name for name in parts.path.split("/") if name]
    node = given.get("node", "cardsflow")
    for name in (*names, node):
        if not _NAME.fullmatch(name):
            raise InputError(f"{name!r} is no name of ROS: letters, digits, underscores", key=uri)
    middleware = _middleware(given.get("rmw"), uri)
    if middleware == "dds" and port is not None:
        raise InputError("DDS finds its ports by the domain: leave out the port", key=uri)
    return NodeAddress(
        middleware,
        parts.hostname or ("localhost" if middleware == "zenoh" else ""),
        port or _PORT,
        _whole(given.get("domain", os.environ.get("ROS_DOMAIN_ID") or "0"), "domain", 0, uri),
        "".join(f"/{name}" for name in names),
        node,
        _reliable(given.get("reliability", "reliable"), uri),
        _whole(given.get("depth", "10"), "depth", 1, uri),
        _timeout(given.get("timeout"), uri),
    )


def _middleware(name: str | None, uri: str) -> Middleware:
    """The middleware of a name; that of ROS's own variable when None."""
    if name is None:
        return _MIDDLEWARE.get(os.environ.get("RMW_IMPLEMENTATION", ""), "zenoh")
    if name not in _MIDDLEWARE:
        raise UnknownNameError("middleware", name, ("zenoh", "dds"), key=uri)
    return _MIDDLEWARE[name]


def _whole(text: str, name: str, least: int, uri: str) -> int:
    most = _MOST_DOMAIN if name == "domain" else _MOST_DEPTH
    if not (text.isascii() and text.isdigit() and len(text) < 9 and least <= int(text) <= most):
        raise InputError(f"the {name} must be {least} to {most}, not {text!r}", key=uri)
    return int(text)


def _reliable(name: str, uri: str) -> bool:
    if name not in _RELIABLE:
        raise UnknownNameError("reliability", name, tuple(_RELIABLE), key=uri)
    return _RELIABLE[name]


def _timeout(text: str | None, uri: str) -> float | None:
    if text is None:
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds < math.inf:
        raise InputError(f"the timeout must be a number of seconds above 0, not {text!r}", key=uri)
    return seconds
