"""Viser server that only accepts requests from its own pages.

A page of any web site can send requests to `http://127.0.0.1:8080` and open a socket to it. The
browser sends the address of the site in the header `Origin`, and the host name of the request in
`Host`. Viser checks neither header. In addition, any client can make viser open a tunnel to the
internet.
"""

from __future__ import annotations

import contextlib
import http
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from addin_sdfusion.robot import InputError

if TYPE_CHECKING:
    from email.message import Message

    from websockets.datastructures import Headers  # dependency of viser

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")

# The page may only load content of this server, so that a file cannot add external addresses.
_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval' data: blob:; "
    "connect-src 'self' ws://127.0.0.1:* ws://localhost:* data: blob:; "
    "frame-src 'none'; object-src 'none'; form-action 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": _POLICY,
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def guarded_server(port: int) -> Any:
    """Start a viser server on loopback.

    Args:
        port: The port; the next free port if it is used.

    Raises:
        ImportError: viser is not installed.
        InputError: This version of viser is not supported.
    """
    import viser

    class LocalServer(viser.ViserServer):  # type: ignore[misc]
        """Viser server that does not open tunnels."""

        def request_share_url(self, verbose: bool = True) -> None:
            """Do nothing instead of opening a tunnel."""

    with _guard() as applied:
        opened = LocalServer(HOST, port, verbose=False)
    if not applied:
        opened.stop()
        what = (
            "the live view does not support this version of viser; install viser 1.1, or use --html"
        )
        raise InputError(what)
    return opened


def is_local_request(headers: Headers | Message) -> bool:
    """Return whether a request has a local host name and does not come from another web site."""
    hosts, origins = headers.get_all("Host") or [], headers.get_all("Origin") or []
    if len(hosts) != 1 or len(origins) > 1 or _host_name(hosts[0]) not in _NAMES:
        return False
    return not origins or origins[0] == f"http://{hosts[0]}"


def _host_name(host: str) -> str | None:
    """Return the host name in `name:port`; None if invalid."""
    try:
        parts = urlsplit(f"//{host}")
        whole = parts.port is None or host.endswith(f":{parts.port}")
        return parts.hostname if whole and parts.username is None and not parts.path else None
    except ValueError:
        return None


@contextlib.contextmanager
def _guard() -> Iterator[list[bool]]:
    """Add checks of `Origin` and `Host` to viser; the yielded list is not empty after success."""
    import websockets.asyncio.server as websockets_server
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    serve, applied = websockets_server.serve, list[bool]()

    def guarded(*args: Any, process_request: Any, **options: Any) -> Any:
        applied.append(True)

        def checked(connection: Any, request: Any) -> Any:
            if not is_local_request(request.headers):
                text = b"This view only accepts requests from its own page on this computer.\n"
                head = Headers({"Content-Length": str(len(text)), "Content-Type": "text/plain"})
                status = http.HTTPStatus.FORBIDDEN
                return Response(status.value, status.phrase, head, text)
            response = process_request(connection, request)
            if isinstance(response, Response):
                for name, value in _HEADERS.items():
                    response.headers[name] = value
            return response

        return serve(*args, process_request=checked, **options)

    websockets_server.serve = guarded  # type: ignore[assignment,misc]
    try:
        yield applied
    finally:
        websockets_server.serve = serve  # type: ignore[misc]
