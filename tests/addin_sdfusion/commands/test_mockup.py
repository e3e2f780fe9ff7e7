"""Tests of the definitions of dialogs, the help page, icons and manifest."""

from __future__ import annotations

import importlib.util
import json
import re
import struct
import uuid
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

import pytest

from addin_sdfusion.commands.check.dialog import DIALOG as CHECK
from addin_sdfusion.commands.define_muscles.dialog import DIALOG as DEFINE
from addin_sdfusion.commands.dialogs import Dialog, Input
from addin_sdfusion.commands.export.dialog import DIALOG as EXPORT
from cardsflow_fmu.version import __version__

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "addin_sdfusion/commands/help.html"
DIALOGS = (DEFINE, CHECK, EXPORT)
dialogs = pytest.mark.parametrize("dialog", DIALOGS, ids=lambda dialog: dialog.name)


def all_inputs(inputs: tuple[Input, ...]) -> Iterator[Input]:
    """Yield every input, parents before children."""
    for item in inputs:
        yield item
        yield from all_inputs(item.children)


def script(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, ROOT / "docs" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_up_to_date() -> None:
    """If this fails, run: python docs/make_addin_page.py --png."""
    assert PAGE.read_text(encoding="utf-8") == script("make_addin_page").page()


def test_the_page_is_self_contained_and_complete() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "<script" not in page
    for dialog in DIALOGS:
        for item in all_inputs(dialog.inputs):
            shown = item.columns if item.kind == "table" else (item.label,)
            assert item.id == "components" or all(escape(text) in page for text in shown)


def test_the_picture_is_small() -> None:
    data = (ROOT / "docs/images/addin_dialogs.png").read_bytes()
    assert data.startswith(b"\x89PNG")
    assert len(data) < 200_000


def test_the_guide_has_a_small_picture_of_each_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """If this fails, run: python docs/make_addin_steps.py."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    steps = list(script("make_addin_steps").steps())
    assert [step.clicks for step in steps][:2] == [5, 10]  # OK is the last click
    guide = (ROOT / "docs/tutorials/muscles_in_fusion.md").read_text(encoding="utf-8")
    for step in steps:
        assert f"../images/fusion/{step.name}.png" in guide
        assert len((ROOT / f"docs/images/fusion/{step.name}.png").read_bytes()) < 60_000
        assert step.page.count("<polyline") == (1 if step is steps[0] else 2)


@dialogs
def test_ids_are_unique_and_inputs_have_tooltips(dialog: Dialog) -> None:
    items = list(all_inputs(dialog.inputs))
    assert len({item.id for item in items}) == len(items)
    for item in items:
        assert re.fullmatch(r"[a-z][a-z_]*[a-z]", item.id)
        assert "__" not in item.id
        assert item.tooltip or item.kind in ("tab", "group")
        assert len(item.columns) == len(item.widths)
        assert item.kind != "selection" or (item.filters and item.prompt)
        assert item.kind != "dropdown" or not item.value or item.value in item.options


@dialogs
def test_icons_have_every_size_of_fusion(dialog: Dialog) -> None:
    folder = ROOT / "addin_sdfusion/commands" / dialog.folder / "resources"
    sizes = {"16x16": 16, "32x32": 32, "64x64": 64, "16x16@2x": 32, "32x32@2x": 64}
    sizes |= {"16x16-disabled": 16, "32x32-disabled": 32}
    for name, size in sizes.items():
        data = (folder / f"{name}.png").read_bytes()
        assert struct.unpack(">II", data[16:24]) == (size, size)
        assert len(data) < 10_000


@dialogs
def test_buttons_have_a_picture_of_their_dialog(dialog: Dialog) -> None:
    file = ROOT / "addin_sdfusion/commands" / dialog.folder / "resources/toolclip.png"
    data = file.read_bytes()
    width, _ = struct.unpack(">II", data[16:24])
    assert width < 600
    assert len(data) < 30_000


def luminance(color: tuple[int, ...]) -> float:
    """Return the relative luminance defined by WCAG 2."""
    parts = [c / 255 for c in color]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("toolbar", [(245, 245, 245), (34, 41, 51)], ids=["light", "dark"])
def test_icons_are_visible_on_light_and_dark_toolbars(toolbar: tuple[int, ...]) -> None:
    """WCAG 2 requires a contrast of 3 to 1 for graphics."""
    made = script("make_addin_icons")
    for color in (made.RED, made.BLUE, made.GREY):
        low, high = sorted((luminance(color), luminance(toolbar)))
        assert (high + 0.05) / (low + 0.05) >= 3.0


@pytest.mark.slow
def test_icons_equal_the_output_of_the_script() -> None:
    """Releases of Pillow may draw edges slightly differently."""
    from PIL import Image, ImageChops

    made = script("make_addin_icons")
    for name, layers in made.ICONS.items():
        file = ROOT / "addin_sdfusion/commands" / name / "resources/32x32.png"
        with Image.open(file) as stored:
            difference = ImageChops.difference(stored, made.icon(layers, 32))
        assert max(high for _, high in difference.getextrema()) <= 16


def test_manifest_contains_product_and_version() -> None:
    manifest = json.loads((ROOT / "addin_sdfusion/addin_sdfusion.manifest").read_text())
    assert manifest["autodeskProduct"] == "Fusion360"
    assert manifest["type"] == "addin"
    assert manifest["version"] == __version__
    assert manifest["supportedOS"] == "windows|mac"
    assert manifest["editEnabled"] is True
    assert uuid.UUID(manifest["id"]).version == 4
    assert manifest["description"][""]
