"""Addresses of ROS nodes: ros2://NAMESPACE?domain=N&node=NAME."""

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
_REMOVED_KEYS = {
    "rmw": "set the environment variable RMW_IMPLEMENTATION to choose the middleware",
    "reliability": "topics are published reliably, and subscribers choose their reliability",
    "depth": "topics are published with depth 10, and subscribers choose their depth",
}
"""Removed options, and their replacements."""


@dataclass(frozen=True, slots=True)
class NodeAddress:
    """Address of a node, and options for commands.

    Attributes:
        namespace: Namespace of the node, with a slash before each part, or empty.
        domain: Id of the ROS domain, or None for the domain of ROS_DOMAIN_ID.
        timeout: Maximum time between commands, in [s], or None if not specified.
        controller: Name of a forward_command_controller of ros2_control, or empty. With a
            controller, commands are `Float64MultiArray` messages, and a joint_state_broadcaster
            publishes the states. Otherwise the topics are `/device_commands` and `/device_states`.
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
        """Return the full name of a topic of the node. `/clock` and `/tf` have no namespace."""
        return topic if topic in ("/clock", "/tf") else f"{self.namespace}{topic}"


def node_address(uri: str) -> NodeAddress:
    """Parse the address of a node.

    Args:
        uri: `ros2://`, followed by namespace and options. By default there are no namespace and no
            timeout, the node is `cardsflow`, and the domain is the domain of ROS_DOMAIN_ID.

    Raises:
        InputError: The address is invalid.
    """
    try:
        parts = urlsplit(uri)
    except ValueError:
        raise InputError(f"invalid address {uri!r}; the form is {FORM}") from None
    if parts.scheme != SCHEME or parts.fragment:
        raise InputError(f"invalid ROS 2 address {uri!r}; the form is {FORM}")
    if ":" in parts.netloc or parts.netloc == "localhost":
        problem = f"a ROS 2 address has no host: remove {parts.netloc!r}; the form is {FORM}; peers"
        problem += " are configured by ROS_DOMAIN_ID, RMW_IMPLEMENTATION and ZENOH_CONFIG_OVERRIDE"
        raise InputError(problem, key=uri)
    query = dict(parse_qsl(parts.query, keep_blank_values=True))
    for key in query:
        if key in _REMOVED_KEYS:
            raise InputError(f"remove {key}: {_REMOVED_KEYS[key]}", key=uri)
        if key not in _KEYS:
            raise UnknownNameError("option", key, _KEYS, key=uri)
    names = [name for name in (parts.netloc, *parts.path.split("/")) if name]
    node, controller = query.get("node", "cardsflow"), query.get("controller", "")
    for name in (*names, node, *([controller] if "controller" in query else [])):
        if not _NAME.fullmatch(name):
            problem = f"invalid ROS name {name!r}; use letters, digits and underscores"
            raise InputError(problem, key=uri)
    return NodeAddress(
        "".join(f"/{name}" for name in names),
        node,
        _domain(query.get("domain"), uri),
        _timeout(query.get("timeout"), uri),
        controller,
    )


def _domain(text: str | None, uri: str) -> int | None:
    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) < 9 and int(text) <= _MAX_DOMAIN):
        raise InputError(f"the domain must be from 0 to {_MAX_DOMAIN}, not {text!r}", key=uri)
    return int(text)


def _timeout(text: str | None, uri: str) -> float | None:
    if text is None:
        return None
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds < math.inf:
        raise InputError(f"the timeout must be a positive time in s, not {text!r}", key=uri)
    return seconds
