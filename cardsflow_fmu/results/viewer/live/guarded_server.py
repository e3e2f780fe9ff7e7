"""A viser server that answers its own pages alone.

A page of any site can ask for `http://127.0.0.1:8080`, and open a socket to it: the browser only
says from where, in `Origin`. A site that gives its own name the address 127.0.0.1 shows in `Host`.
Viser looks at neither, and lets any client make it open a tunnel to the internet.
"""

from __future__ import annotations

import contextlib
import http
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from addin_sdfusion.robot import InputError

if TYPE_CHECKING:
    from websockets.datastructures import Headers  # as viser does

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")

# Nothing but what the server gives, so that no text of a file makes the browser ask elsewhere.
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
    """A viser server on loopback.

    Args:
        port: The port, or the next one that is free.

    Raises:
        ImportError: viser is missing.
        InputError: This version of viser cannot be guarded.
    """
    import viser

    class LocalServer(viser.ViserServer):  # type: ignore[misc]
        """A server that stays on this machine."""

        def request_share_url(self, verbose: bool = True) -> None:
            """Open no tunnel, whoever asks for one."""

    with _guard() as applied:
        opened = LocalServer(HOST, port, verbose=False)
    if not applied:
        opened.stop()
        what = "the live view does not know this version of viser: install viser 1.1, or use --html"
        raise InputError(what)
    return opened


def is_own(headers: Headers) -> bool:
    """Whether a request is to this machine by its own name, and not from another site's page."""
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1 or len(origins) > 1 or _name(hosts[0]) not in _NAMES:
        return False
    return not origins or origins[0] == f"http://{hosts[0]}"


def _name(host: str) -> str | None:
    """The name in `name:port`."""
    try:
        parts = urlsplit(f"//{host}")
        whole = parts.port is None or host.endswith(f":{parts.port}")
        return parts.hostname if whole and parts.username is None and not parts.path else None
    except ValueError:
        return None


@contextlib.contextmanager
def _guard() -> Iterator[list[bool]]:
    """Have the server that viser opens look at `Origin` and `Host`; tells whether it does."""
    import websockets.asyncio.server as websockets_server
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    serve, applied = websockets_server.serve, list[bool]()

    def guarded(*args: Any, process_request: Any, **options: Any) -> Any:
        applied.append(True)

        def checked(connection: Any, request: Any) -> Any:
            if not is_own(request.headers):
                text = b"This view is for its own page on this machine.\n"
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
