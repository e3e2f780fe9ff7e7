"""Server of one page on loopback, which only answers requests from this computer.

A page that changes files has actions and a token. The address contains the token, so that other
users of the computer cannot read the page, and each request of an action contains it.
"""

from __future__ import annotations

import contextlib
import hmac
import http.server
import json
import re
import secrets
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from addin_sdfusion.robot import CardsflowError, InputError
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.limits import JSON

from .local_requests import HOST, is_local_request

_FIRST_PORT, _PORTS = 8080, 100
_RELOAD = b"event: reload\ndata:\n\n"
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "frame-ancestors 'none'",
}


Action = Callable[[Mapping[str, Any]], Mapping[str, Any]]
"""Function of the JSON object in a request; returns the JSON object of the answer."""
Page = str | Callable[[], str]


class PageServer:
    """Page that can be replaced, and events for it; threads can use it at the same time.

    Args:
        page: The page in HTML, which contains everything that it needs; or a function that returns
            it for each request.
        actions: Actions of POST requests by path.
        token: Token of the address and of actions; empty for a page without actions.

    Attributes:
        path: Path of the page, with the token.
    """

    def __init__(
        self, page: Page, actions: Mapping[str, Action] | None = None, token: str = ""
    ) -> None:
        self.address, self.path = "", f"/?token={token}" if token else "/"
        self.actions, self._token = actions or {}, token
        self._page, self._event, self._number = page, b"", 0
        self._closed = False
        self._changed = threading.Condition()

    @property
    def page(self) -> bytes:
        """The page as UTF-8."""
        page = self._page
        return (page if isinstance(page, str) else page()).encode()

    def is_authorised(self, token: object) -> bool:
        """Return whether a request has the token."""
        received = token.encode("utf-8", "replace") if isinstance(token, str) else b""
        return bool(self._token) and hmac.compare_digest(received, self._token.encode())

    def send(self, text: str) -> None:
        """Send a line of text to the page; a slow page omits all but the last one."""
        self._publish(f"data: {text}\n\n".encode())

    def replace(self, page: str) -> None:
        """Replace the page, and reload it in the browser."""
        self._page = page
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


def new_token() -> str:
    """Return a new token, which cannot be guessed."""
    return secrets.token_urlsafe(24)


@contextlib.contextmanager
def page_server(
    page: Page,
    port: int | None = None,
    actions: Mapping[str, Action] | None = None,
    token: str = "",
) -> Iterator[PageServer]:
    """Serve a page on loopback.

    Args:
        page: The page, as for `PageServer`.
        port: The port (default: the first free port from 8080).
        actions: Actions of POST requests by path, such as `/save`.
        token: Token from `new_token` for actions; empty for a page without actions.
    """
    served = PageServer(page, actions, token)

    class Handler(_Handler):
        """Handler of this page."""

        server_of_page = served

    server = _open(Handler, port)
    served.address = f"http://{HOST}:{server.server_address[1]}{served.path}"
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
        elif self.path == "/" != self.server_of_page.path:
            self.send_error(http.HTTPStatus.FORBIDDEN, "Use the printed address with its token")
        elif self.path == self.server_of_page.path:
            self._send_page()
        elif self.path == "/frames":
            self._start("text/event-stream")
            for event in self.server_of_page.events():
                self.wfile.write(event)
        else:
            self.send_error(http.HTTPStatus.NOT_FOUND)

    def _send_page(self) -> None:
        try:
            page = self.server_of_page.page
        except CardsflowError as error:
            self.send_error(http.HTTPStatus.INTERNAL_SERVER_ERROR, explain=str(error))
            return
        self._start("text/html; charset=utf-8", len(page))
        self.wfile.write(page)

    def do_POST(self) -> None:
        """Answer the request of an action."""
        action = self.server_of_page.actions.get(self.path)
        if not is_local_request(self.headers):
            self.send_error(http.HTTPStatus.FORBIDDEN)
        elif action is None:
            self.send_error(http.HTTPStatus.NOT_FOUND)
        else:
            request = self._read_request()
            if request is None:
                self.send_error(http.HTTPStatus.BAD_REQUEST)
            elif not self.server_of_page.is_authorised(request.get("token")):
                self.send_error(http.HTTPStatus.FORBIDDEN)
            else:
                answer = json_text(action(request)).encode()
                self._start("application/json", len(answer))
                self.wfile.write(answer)

    def _read_request(self) -> Mapping[str, Any] | None:
        """Return the JSON object of a request; None if it is invalid or too large."""
        size = self.headers.get("Content-Length", "")
        is_json = self.headers.get_content_type() == "application/json"
        if not is_json or not re.fullmatch("[0-9]{1,9}", size) or int(size) > JSON:
            return None
        try:
            request = json.loads(self.rfile.read(int(size)))
        except (ValueError, RecursionError):
            return None
        return request if isinstance(request, dict) else None

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
