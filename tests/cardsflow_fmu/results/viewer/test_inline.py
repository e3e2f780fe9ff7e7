"""Pages of `show()` in notebooks and scripts."""

from __future__ import annotations

import html
import re
import webbrowser
from pathlib import Path

import pytest
from support.robots.robots import PLANAR_2R, planar_2r

from cardsflow_fmu import Experiment


@pytest.mark.parametrize("kind", ["robot", "experiment"])
def test_show_returns_the_page_in_a_frame_without_file_addresses(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    shown = (planar_2r() if kind == "robot" else Experiment.load(PLANAR_2R)).show()
    text = shown._repr_html_()
    assert html.unescape(re.search(r'srcdoc="([^"]*)"', text)[1]) == shown.html
    assert "file:" not in text
    assert [url.startswith("file:") for url in opened] == [True]  # a script opens the browser
    assert shown.save(tmp_path / "page.html").read_text() == shown.html
