"""The engine of pages that simulate, in a browser without a viewer."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from support.browser import Page

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.browser.modes import MODES, Mode
from cardsflow_fmu.models.browser.pack import engine_text
from cardsflow_fmu.results.viewer.html.play_page import engine_script
from cardsflow_fmu.utils.html_page import html_page, script_element

SCRIPTS = ("module", "crc32", "drawing", "changes", "analysis", "engine")
"""Scripts of the worker, without its messages."""

_OPEN = """
async function openEngine(text) {
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return Engine.open(new Uint8Array(await new Response(stream).arrayBuffer()));
}
"""


def _require_compiler() -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")


def open_engine(
    browser: Page, experiment: Experiment, folder: Path, modes: Sequence[Mode] = MODES
) -> None:
    """Open a page from disk, offline, with the engine of an experiment in the variable `engine`."""
    _require_compiler()
    scripts = engine_script(*SCRIPTS) + _OPEN
    text = json.dumps(engine_text(experiment, modes))
    file = folder / "engine.html"
    start = f"let engine; openEngine({text}).then(found => {{ engine = found; }});"
    file.write_text(f"<script>{scripts}\n{start}</script>", "utf-8")
    browser.open(file.as_uri(), offline=True)
    browser.wait_for("window.openEngine && engine")


def open_client(browser: Page, experiment: Experiment, folder: Path) -> None:
    """Open a page with a worker, offline; the client is the variable `play`."""
    _require_compiler()
    worker = engine_script(*SCRIPTS, "worker")
    start = """
    let play, wrong = ""; const frames = [], $ = id => document.getElementById(id).textContent;
    EngineClient.open($("engine"), $("engine-script")).then(found => {
      play = found;
      play.onframe = frame => frames.push(frame);
      play.onfailure = message => { wrong = message; };
    }, error => { wrong = error.message; });
    """
    script = engine_script("client") + start
    text = html_page(
        "play",
        "",
        f'<script type="text/plain" id="engine">{engine_text(experiment)}</script>',
        f'<script type="text/plain" id="engine-script">{worker}</script>',
        script_element(script),
        scripts=[script],
        simulates=True,
    )
    file = folder / "play.html"
    file.write_text(text, "utf-8")
    browser.open(file.as_uri(), offline=True)
    browser.wait_for("typeof play !== 'undefined' && (play || wrong)")


def engine_values(browser: Page, count: int) -> dict[str, float]:
    """Run some steps; return the outputs by name, with and without the name of the model."""
    script = f"engine.run({count}), [engine.columns.map(c => c.name), [...engine.values()]]"
    names, values = browser.evaluate(script)
    full = dict(zip(names, values, strict=True))
    return {name.partition(".")[2]: value for name, value in full.items()} | full
