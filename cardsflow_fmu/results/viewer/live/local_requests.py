"""Checks of requests to a server on loopback.

A page of any web site can send requests to `http://127.0.0.1:8080`. The browser sends the address
of the site in the header `Origin`, and the host name of the request in `Host`.
"""

from __future__ import annotations

from email.message import Message
from urllib.parse import urlsplit

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")


def is_local_request(headers: Message) -> bool:
    """Return whether a request has a local host name and does not come from another web site."""
    hosts, origins = headers.get_all("Host") or [], headers.get_all("Origin") or []
    if len(hosts) != 1 or len(origins) > 1 or _host_name(hosts[0]) not in _NAMES:
        return False
    return not origins or origins[0] == f"http://{hosts[0]}"


def _host_name(host: str) -> str | None:
    """Return the host name in `name:port`; None if invalid."""
    try:
        parts = urlsplit(f"//{host}")
        is_valid = parts.port is None or host.endswith(f":{parts.port}")
        return parts.hostname if is_valid and parts.username is None and not parts.path else None
    except ValueError:
        return None
