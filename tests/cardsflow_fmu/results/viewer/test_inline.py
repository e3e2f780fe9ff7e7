"""Pages of `show()` in notebooks and scripts."""

from __future__ import annotations

import html
import re
import webbrowser
from pathlib import Path

import pytest
from support.robots.robots import PLANAR_2R, planar_2r

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.browser import pack


@pytest.mark.parametrize("has_module", [True, False])
@pytest.mark.parametrize("kind", ["robot", "experiment"])
def test_show_returns_the_page_in_a_frame_without_file_addresses(
    kind: str, has_module: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def module() -> bytes:
        if not has_module:
            raise InputError("the compiler is missing")
        return b"module"

    monkeypatch.setattr(pack, "wasm_module", module)
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    shown = (planar_2r() if kind == "robot" else Experiment.load(PLANAR_2R)).show()
    text = shown._repr_html_()
    assert html.unescape(re.search(r'srcdoc="([^"]*)"', text)[1]) == shown.html
    assert "file://" not in text
    assert text.isascii()
    assert ('id="engine"' in shown.html) == has_module
    assert [url.startswith("file:") for url in opened] == [True]  # a script opens the browser
    assert shown.save(tmp_path / "page.html").read_text() == shown.html
