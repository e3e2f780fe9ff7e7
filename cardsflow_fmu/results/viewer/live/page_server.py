"""Server of one page on loopback, which only answers requests from this computer."""

from __future__ import annotations

import contextlib
import http.server
import threading
from collections.abc import Iterator

from addin_sdfusion.robot import InputError

from .guarded_server import HOST, is_local_request

_FIRST_PORT, _PORTS = 8080, 100


@contextlib.contextmanager
def served_page(page: str, port: int | None = None) -> Iterator[str]:
    """Serve a page and yield its address.

    Args:
        page: The page in HTML, which contains everything that it needs.
        port: The port (default: the first free port from 8080).

    Raises:
        InputError: The port is used.
    """
    contents = page.encode()

    class Handler(http.server.BaseHTTPRequestHandler):
        """Answers requests for the page."""

        def do_GET(self) -> None:
            """Send the page."""
            if not is_local_request(self.headers):
                self.send_error(http.HTTPStatus.FORBIDDEN)
            elif self.path != "/":
                self.send_error(http.HTTPStatus.NOT_FOUND)
            else:
                self.send_response(http.HTTPStatus.OK)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(contents)))
                self.send_header("Cache-Control", "no-store")
                self.send_header("Referrer-Policy", "no-referrer")
                self.send_header("X-Content-Type-Options", "nosniff")
                self.send_header("Content-Security-Policy", "frame-ancestors 'none'")
                self.end_headers()
                self.wfile.write(contents)

        def log_message(self, *_: object) -> None:
            """Print nothing."""

    server = _open(Handler, port)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{server.server_address[1]}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def _open(
    handler: type[http.server.BaseHTTPRequestHandler], port: int | None
) -> http.server.ThreadingHTTPServer:
    ports = range(_FIRST_PORT, _FIRST_PORT + _PORTS) if port is None else [port]
    for one in ports:
        with contextlib.suppress(OSError):
            return _Server((HOST, one), handler)
    text = f"{ports[0]}" if len(ports) == 1 else f"{ports[0]} to {ports[-1]}"
    raise InputError(f"port {text} is used; choose another port", key="--port")


class _Server(http.server.ThreadingHTTPServer):
    allow_reuse_address = False
    daemon_threads = True
