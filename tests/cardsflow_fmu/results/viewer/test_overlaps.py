"""Texts of all pages of all examples: none overlaps another one or leaves the window."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from support.browser import Page
from support.robots.robots import EXAMPLES

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.results.viewer.html.play_page import play_page
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.view import act_of, page_of, still_act
from cardsflow_fmu.simulation.run import simulate

OVERLAPS = (Path(__file__).parent / "overlaps.js").read_text(encoding="utf-8")
SIZES = ((1400, 900), (1024, 768), (390, 844))
NAMES = sorted(
    file.parent.name
    for file in EXAMPLES.glob("*/experiment.toml")
    if '"optimised"' not in file.read_text(encoding="utf-8")
)
LONG = "the reference is not followed: " + "a long text about a joint at its limit, " * 6
_CUT_OFF = """
[...document.querySelectorAll('.bar > :is(button, output, select)')].filter(part => {
  const r = part.getBoundingClientRect();
  const isOut = r.left < 0 || r.right > innerWidth || r.bottom > innerHeight;
  return isOut || r.width < 12 || part.scrollWidth > part.clientWidth + 1;
}).map(part => part.ariaLabel || part.textContent)
"""
_LABELS = "document.querySelector('input[name=\"joint values\"]')?.click()"
_FRAME = "new Promise(done => requestAnimationFrame(done))"


def pages_of(name: str) -> dict[str, str]:
    """Return the pages of an example: robot, experiment, a failed run, and two runs."""
    experiment = Experiment.load(EXAMPLES / name, {"run.coupling": "direct"})
    run = experiment.run.copy_with(duration=10 * experiment.controller.period)
    experiment = Experiment.load(EXAMPLES / name, {"run.duration": run.duration})
    shown = act_of(simulate(experiment, coupling="direct"))
    failed = Act(shown.stage, shown.title, (f"FAILED: {LONG}", *shown.notes), shown.signals)
    pages = {
        "robot": page_of([still_act(experiment.robot)]),
        "failed run": page_of([failed]),
        "two runs": page_of([shown, failed]),
    }
    if not experiment.fmus and not experiment.hardware.use:
        pages["play"] = play_page(experiment)
    return pages


@pytest.mark.browser
@pytest.mark.cases(2)
@pytest.mark.parametrize("name", NAMES)
def test_no_texts_overlap(page: Page, tmp_path: Path, name: str) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    file, found = tmp_path / "page.html", []
    for kind, text in pages_of(name).items():
        file.write_text(text, "utf-8")
        page.resize(*SIZES[0])
        page.open("about:blank")
        page.open(file.as_uri(), offline=True)
        page.wait_for("document.body?.dataset.drawn")
        page.evaluate(_LABELS)
        for size in SIZES:
            page.resize(*size)
            for is_open in ("true", "false"):
                page.evaluate(f"document.querySelector('.panel').open = {is_open}; {_FRAME}")
                texts = page.evaluate(OVERLAPS) + page.evaluate(_CUT_OFF)
                found += [(kind, size, is_open, text) for text in texts]
    assert found == []
    assert page.errors == []
