"""Server of one page on loopback, which only answers requests from this computer."""

from __future__ import annotations

import contextlib
import http.server
import threading
from collections.abc import Iterator

from addin_sdfusion.robot import InputError

from .local_requests import HOST, is_local_request

_FIRST_PORT, _PORTS = 8080, 100
_RELOAD = b"event: reload\ndata:\n\n"
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "frame-ancestors 'none'",
}


class PageServer:
    """Page that can be replaced, and events for it; threads can use it at the same time.

    Args:
        page: The page in HTML, which contains everything that it needs.

    Attributes:
        address: Address for a browser.
    """

    def __init__(self, page: str) -> None:
        self.address = ""
        self._page, self._event, self._number = page.encode(), b"", 0
        self._closed = False
        self._changed = threading.Condition()

    @property
    def page(self) -> bytes:
        """The page as UTF-8."""
        return self._page

    def send(self, text: str) -> None:
        """Send a line of text to the page; a slow page omits all but the last one."""
        self._publish(f"data: {text}\n\n".encode())

    def replace(self, page: str) -> None:
        """Replace the page, and reload it in the browser."""
        self._page = page.encode()
        self._publish(_RELOAD)

    def close(self) -> None:
        """End all streams of events."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def events(self) -> Iterator[bytes]:
        """Yield events until the server closes."""
        seen = 0
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._number > seen)  # noqa: B023
                if self._closed:
                    return
                seen, event = self._number, self._event
            yield event

    def _publish(self, event: bytes) -> None:
        with self._changed:
            self._event, self._number = event, self._number + 1
            self._changed.notify_all()


@contextlib.contextmanager
def served_page(page: str, port: int | None = None) -> Iterator[str]:
    """Serve a page and yield its address; arguments and errors as for `page_server`."""
    with page_server(page, port) as server:
        yield server.address


@contextlib.contextmanager
def page_server(page: str, port: int | None = None) -> Iterator[PageServer]:
    """Serve a page on loopback.

    Args:
        page: The page in HTML, which contains everything that it needs.
        port: The port (default: the first free port from 8080).

    Raises:
        InputError: The port is used.
    """
    served = PageServer(page)

    class Handler(_Handler):
        """Handler of this page."""

        server_of_page = served

    server = _open(Handler, port)
    served.address = f"http://{HOST}:{server.server_address[1]}/"
    thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
    thread.start()
    try:
        yield served
    finally:
        served.close()
        server.shutdown()
        server.server_close()
        thread.join()


class _Handler(http.server.BaseHTTPRequestHandler):
    """Answers requests for the page at `/` and its events at `/frames`."""

    server_of_page: PageServer
    timeout = 60.0  # of a client that sends nothing, in [s]

    def do_GET(self) -> None:
        """Send the page, or its events."""
        if not is_local_request(self.headers):
            self.send_error(http.HTTPStatus.FORBIDDEN)
        elif self.path == "/":
            page = self.server_of_page.page
            self._start("text/html; charset=utf-8", len(page))
            self.wfile.write(page)
        elif self.path == "/frames":
            self._start("text/event-stream")
            for event in self.server_of_page.events():
                self.wfile.write(event)
        else:
            self.send_error(http.HTTPStatus.NOT_FOUND)

    def _start(self, kind: str, length: int | None = None) -> None:
        self.send_response(http.HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, *_: object) -> None:
        """Print nothing."""


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
    block_on_close = False  # a stream of events ends only with its client

    def handle_error(self, *_: object) -> None:
        """Ignore errors of clients, such as closed connections."""
