"""Addresses of nodes: ros2://NAMESPACE?domain=N&node=NAME."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from urllib.parse import parse_qsl, urlsplit

from addin_sdfusion.robot import InputError, UnknownNameError

SCHEME = "ros2"
FORM = "ros2://NAMESPACE?domain=N&node=NAME"

_MAX_DOMAIN = 232
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_KEYS = ("domain", "node", "timeout", "controller")
_OF_ROS = {
    "rmw": "the middleware is chosen by the environment variable RMW_IMPLEMENTATION",
    "reliability": "topics are published reliably; a subscriber chooses for itself",
    "depth": "topics are published with depth 10; a subscriber chooses for itself",
}
"""Options of earlier versions, and what takes their place."""


@dataclass(frozen=True, slots=True)
class NodeAddress:
    """The name of a node, and how commands go by its topics.

    Attributes:
        namespace: Namespace of the node, with a slash before every part; empty for none.
        node: Name of the node.
        domain: Number of the ROS domain; that of ROS_DOMAIN_ID when None.
        timeout: Longest time without a command, in [s]; None if it is not stated.
        controller: Name of a forward_command_controller: commands are a `Float64MultiArray` for it
            and states those of a joint_state_broadcaster. Empty for our own pair of topics.
    """

    namespace: str = ""
    node: str = "cardsflow"
    domain: int | None = None
    timeout: float | None = None
    controller: str = ""

    def __str__(self) -> str:
        domain = "" if self.domain is None else f" in domain {self.domain}"
        return f"{self.namespace}/{self.node}{domain}"

    def absolute(self, topic: str) -> str:
        """Full name of a topic of the node; `/clock` and `/tf` have no namespace."""
        return topic if topic in ("/clock", "/tf") else f"{self.namespace}{topic}"


def node_address(uri: str) -> NodeAddress:
    """Read an address.

    Args:
        uri: `ros2://`, with what differs from the defaults: no namespace, node `cardsflow`, the
            domain of ROS_DOMAIN_ID, no timeout.

    Raises:
        InputError: It is not such an address.
    """
    try:
        parts = urlsplit(uri)
    except ValueError:
        raise InputError(f"{uri!r} is not an address; give {FORM}") from None
    if parts.scheme != SCHEME or parts.fragment:
        raise InputError(f"{uri!r} is not an address of ROS 2; give {FORM}")
    if ":" in parts.netloc or parts.netloc == "localhost":
        what = "ROS 2 finds its peers by its own configuration (ROS_DOMAIN_ID, RMW_IMPLEMENTATION, "
        what += f"ZENOH_CONFIG_OVERRIDE for a router): leave out {parts.netloc!r}, give {FORM}"
        raise InputError(what, key=uri)
    given = dict(parse_qsl(parts.query, keep_blank_values=True))
    for key in given:
        if key in _OF_ROS:
            raise InputError(f"leave out {key}: {_OF_ROS[key]}", key=uri)
        if key not in _KEYS:
            raise UnknownNameError("option", key, _KEYS, key=uri)
    names = [name for name in (parts.netloc, *parts.path.split("/")) if name]
    node, controller = given.get("node", "cardsflow"), given.get("controller", "")
    for name in (*names, node, *([controller] if "controller" in given else [])):
        if not _NAME.fullmatch(name):
            what = f"{name!r} is not a name of ROS: letters, digits, underscores"
            raise InputError(what, key=uri)
    return NodeAddress(
        "".join(f"/{name}" for name in names),
        node,
        _domain(given.get("domain"), uri),
        _timeout(given.get("timeout"), uri),
        controller,
    )


def _domain(text: str | None, uri: str) -> int | None:
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 9 and int(text) <= _MAX_DOMAIN):
        raise InputError(f"the domain must be 0 to {_MAX_DOMAIN}, not {text!r}", key=uri)
    return int(text)


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
