"""The page that simulates, in Firefox."""

from pathlib import Path

import pytest
from support.firefox import opened_firefox
from support.robots.robots import EXAMPLES

from cardsflow_fmu.cli.main import main
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.native_loop import native_loop


@pytest.mark.browser
def test_page_from_disk_plays_as_the_native_library(tmp_path: Path) -> None:
    pytest.importorskip("ziglang", reason="needs the extra `cross`")
    file = tmp_path / "play.html"
    assert main(["play", str(EXAMPLES / "planar_2r"), "--html", str(file)]) == 0
    profile = tmp_path / "profile"
    profile.mkdir()
    with opened_firefox(profile) as page:
        page.open(file.as_uri())
        page.wait_for("document.body.dataset.drawn && play.client.frame")
        page.evaluate("document.querySelector('[aria-label=play]').click()")
        page.wait_for("play.client.frame.time > 0.2")
        time, q = page.evaluate("[play.client.frame.time, [...play.client.frame.q]]")
        assert not page.errors
    run = native_loop(Experiment.load(EXAMPLES / "planar_2r")).run()
    k = round(time / 1e-3)
    assert [run.rows[k, run.names.index(f"q.joint_{j}")] for j in (1, 2)] == q
