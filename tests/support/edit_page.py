"""Pages of `cardsflow edit` in a browser, with their server."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from cardsflow_fmu.results.viewer.html.edit_page import edit_page
from cardsflow_fmu.results.viewer.live.page_server import new_token, page_server
from cardsflow_fmu.simulation.edit import EditSession

from .browser import Page


@contextlib.contextmanager
def served_editor(browser: Page, robot: Path) -> Iterator[None]:
    """Serve the page of a robot and open it; wait for the first evaluation."""
    session, token = EditSession(robot, report=lambda line: None), new_token()
    page = edit_page(session.robot, session.file.parent, session.data(token))
    actions = {"/evaluate": session.evaluate, "/save": session.save}
    browser.send(
        "Network.emulateNetworkConditions",
        offline=False,
        latency=0,
        downloadThroughput=-1,
        uploadThroughput=-1,
    )
    with page_server(page, None, actions, token) as server:
        browser.open(server.address)
        browser.wait_for("window.edit?.result && !edit.server.isBusy && edit.result.arms")
        yield
