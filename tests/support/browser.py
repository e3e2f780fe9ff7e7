"""Headless Chromium for tests, controlled over its DevTools protocol."""

from __future__ import annotations

import base64
import contextlib
import io
import json
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

SIZE = (1000, 700)
"""Size of the window of tests, in pixels."""

_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-port=0",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-default-apps",
    "--window-size=1000,700",
    "--hide-scrollbars",
)


NO_DRAWING = """
for (const name of ["drawElementsInstanced", "drawElements", "drawArrays"])
  WebGL2RenderingContext.prototype[name] = () => {};
"""
"""Script for tests that look at no picture: drawing takes most time without a graphics card."""


REPLACED = ("Inspected target navigated or closed", "Execution context was destroyed.")
"""Errors of an evaluation during which the page is replaced by another one."""


class ReplacedPageError(Exception):
    """The page was replaced by another one before it answered."""


class Page:
    """A browser tab.

    Attributes:
        requests: URLs of all requests of the page.
        errors: Exceptions, console errors and failed requests, as text.
    """

    def __init__(self, socket: Any) -> None:
        self._socket, self._number = socket, 0
        self.requests: list[str] = []
        self.errors: list[str] = []
        self._scripts: list[str] = []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.send(f"{domain}.enable")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the protocol; events that arrive before its answer are stored."""
        self._number += 1
        call = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(call))
        while True:
            message = json.loads(self._socket.recv(timeout=300))
            if message.get("id") == self._number:
                if message.get("error", {}).get("message") in REPLACED:
                    raise ReplacedPageError(method)
                assert "error" not in message, message["error"]
                return message["result"]
            self._note(message)

    def open(self, url: str, *, offline: bool = False) -> None:
        """Open a page; `offline` first disconnects the tab from the network."""
        if offline:
            self.send(
                "Network.emulateNetworkConditions",
                offline=True,
                latency=0,
                downloadThroughput=0,
                uploadThroughput=0,
            )
        self.send("Page.navigate", url=url)

    def run_first(self, script: str) -> None:
        """Run a script at the start of each page, until `reset`."""
        made = self.send("Page.addScriptToEvaluateOnNewDocument", source=script)
        self._scripts.append(made["identifier"])

    def resize(self, width: int, height: int) -> None:
        """Change the size of the window."""
        self.send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def reset(self) -> None:
        """Close the page, and begin with a window of the first size and a network."""
        while self._scripts:
            script = self._scripts.pop()
            self.send("Page.removeScriptToEvaluateOnNewDocument", identifier=script)
        self.open("about:blank")
        self.send(
            "Network.emulateNetworkConditions",
            offline=False,
            latency=0,
            downloadThroughput=-1,
            uploadThroughput=-1,
        )
        self.send("Emulation.setEmulatedMedia", features=[])
        self.send("Input.dispatchMouseEvent", type="mouseMoved", x=0, y=0)
        self.resize(*SIZE)
        self.evaluate("0")
        self.requests.clear()
        self.errors.clear()

    def evaluate(self, expression: str) -> Any:
        """Return the value of a JavaScript expression."""
        result = self.send(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    def wait_for(self, expression: str, seconds: float = 300.0) -> float:
        """Wait until an expression is true, also on a later page; return the time, in [s]."""
        begin = time.perf_counter()
        while not self._is_true(expression):
            assert time.perf_counter() - begin < seconds, (expression, self.errors)
            time.sleep(0.05)
        return time.perf_counter() - begin

    def _is_true(self, expression: str) -> bool:
        try:
            return bool(self.evaluate(f"!!({expression})"))
        except ReplacedPageError:
            return False

    def show_changes(self) -> None:
        """Wait until the page shows the last change."""
        self.evaluate(
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )

    def click(self, selector: str) -> None:
        """Click the centre of an element with the mouse."""
        x, y = self.evaluate(
            f"(r => [r.x + r.width / 2, r.y + r.height / 2])"
            f"(document.querySelector({selector!r}).getBoundingClientRect())"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def screenshot(self, file: Path | None = None) -> np.ndarray:
        """Return a screenshot, shape (height, width, 3), 0 to 255."""
        from PIL import Image

        data = base64.b64decode(self.send("Page.captureScreenshot", format="png")["data"])
        if file is not None:
            file.write_bytes(data)
        with Image.open(io.BytesIO(data)) as image:
            return np.asarray(image.convert("RGB")).astype(int)

    def _note(self, message: dict[str, Any]) -> None:
        method, parameters = message.get("method"), message.get("params", {})
        if method in ("Network.requestWillBeSent", "Network.webSocketCreated"):
            self.requests.append(parameters.get("url") or parameters["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.errors.append(str(parameters["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert"):
            self.errors.append(str(parameters["args"]))
        elif method == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.errors.append(str(parameters["entry"]))


@contextlib.contextmanager
def opened_browser(folder: Path, size: tuple[int, int] = SIZE) -> Iterator[Page]:
    """Start a browser with its profile in a folder; yield its tab. Skip without Chromium."""
    client = pytest.importorskip("websockets.sync.client", reason="needs websockets")
    if CHROMIUM is None:
        pytest.skip("chromium is not installed")
    command = [CHROMIUM, *_FLAGS, f"--user-data-dir={folder / 'profile'}", "about:blank"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        url = _debugger(folder / "profile" / "DevToolsActivePort", process)
        with client.connect(url, max_size=2**26, open_timeout=300) as socket:
            page = Page(socket)
            page.resize(*size)
            yield page
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _debugger(port_file: Path, process: subprocess.Popen) -> str:
    """Wait for the browser; return the address of its first tab."""
    begin = time.perf_counter()
    while True:
        assert process.poll() is None, "chromium has ended"
        assert time.perf_counter() - begin < 300.0, "chromium does not start"
        time.sleep(0.05)
        with contextlib.suppress(OSError, ValueError, IndexError, KeyError):
            port = int(port_file.read_text().splitlines()[0])
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json", timeout=5) as answer:
                tabs = json.load(answer)
            return next(t["webSocketDebuggerUrl"] for t in tabs if t["type"] == "page")
