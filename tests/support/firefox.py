"""Firefox on a virtual display for tests, controlled over WebDriver BiDi.

Without a display, Firefox has no WebGL.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
XVFB = shutil.which("Xvfb")
_WAIT = 120.0  # in [s]
_PREFERENCES = """
user_pref("browser.shell.checkDefaultBrowser", false);
user_pref("datareporting.policy.dataSubmissionEnabled", false);
user_pref("network.captive-portal-service.enabled", false);
user_pref("toolkit.telemetry.enabled", false);
user_pref("webgl.force-enabled", true);
"""


class FirefoxPage:
    """A tab of Firefox.

    Attributes:
        errors: Exceptions and console errors, as text.
    """

    def __init__(self, connection: Any) -> None:
        self._connection, self._number = connection, 0
        self.errors: list[str] = []
        self.send("session.new", capabilities={})
        self.send("session.subscribe", events=["log.entryAdded"])
        self._tab = self.send("browsingContext.getTree")["contexts"][0]["context"]

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the protocol; errors that the page logs meanwhile are stored."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        self._connection.send(json.dumps(message))
        while True:
            answer = json.loads(self._connection.recv(timeout=_WAIT))
            if answer.get("id") == self._number:
                assert answer["type"] == "success", answer
                return answer["result"]
            if answer.get("method") == "log.entryAdded" and answer["params"]["level"] == "error":
                self.errors.append(str(answer["params"]))

    def open(self, url: str) -> None:
        """Open a page and wait until it has loaded."""
        self.send("browsingContext.navigate", context=self._tab, url=url, wait="complete")

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression that can be written as JSON."""
        result = self.send(
            "script.evaluate",
            expression=f"JSON.stringify({expression})",
            target={"context": self._tab},
            awaitPromise=True,
        )
        assert result["type"] == "success", result
        return json.loads(result["result"].get("value", "null"))

    def wait_for(self, expression: str) -> None:
        """Wait until an expression is true."""
        begin = time.perf_counter()
        while not self.evaluate(f"!!({expression})"):
            assert time.perf_counter() - begin < _WAIT, (expression, self.errors)
            time.sleep(0.05)


@contextlib.contextmanager
def opened_firefox(folder: Path) -> Iterator[FirefoxPage]:
    """Start Firefox with its profile in a folder; yield its tab. Skip without Firefox."""
    client = pytest.importorskip("websockets.sync.client", reason="needs websockets")
    if FIREFOX is None or XVFB is None:
        pytest.skip("firefox-esr or xvfb is not installed")
    (folder / "user.js").write_text(_PREFERENCES)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    firefox = [FIREFOX, "--no-remote", "--profile", str(folder), "about:blank"]
    with (
        _started([XVFB, "-screen", "0", "1200x900x24", "-displayfd", "1"]) as screen,
        _started(
            [*firefox, f"--remote-debugging-port={port}"],
            DISPLAY=f":{screen.stdout.readline().strip()}",
            LIBGL_ALWAYS_SOFTWARE="1",
        ) as browser,
        _connect(client, port, browser) as connection,
    ):
        yield FirefoxPage(connection)


@contextlib.contextmanager
def _started(command: list[str], **variables: str) -> Iterator[Any]:
    """Start a process with further variables of the environment; end it."""
    process = subprocess.Popen(
        command,
        env=os.environ | variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def _connect(client: Any, port: int, process: subprocess.Popen[str]) -> Any:
    begin = time.perf_counter()
    while True:
        assert process.poll() is None, "firefox has ended"
        assert time.perf_counter() - begin < _WAIT, "firefox does not start"
        with contextlib.suppress(OSError):
            return client.connect(f"ws://127.0.0.1:{port}/session", max_size=2**26)
        time.sleep(0.05)
