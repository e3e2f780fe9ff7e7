"""Page that simulates: layout, names, views and tooltips."""

import importlib.util
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.browser import Page
from support.robots.robots import EXAMPLES

from cardsflow_fmu.cli.main import main

PICTURES = True
OVERLAPS = (Path(__file__).parent / "overlaps.js").read_text(encoding="utf-8")
EVIL = "<img src=x onerror=hit=1></script><script>hit=1</script>"


def _point_at(page: Page, point: str) -> None:
    """Move the pointer to a point of the scene, an expression."""
    x, y = page.evaluate(
        "(() => { const canvas = document.querySelector('canvas');"
        " const { view } = play.camera.uniforms(canvas.clientWidth / canvas.clientHeight);"
        f" const [x, y] = project(view, {point});"
        " return [x * canvas.clientWidth, y * canvas.clientHeight]; })()"
    )
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)


def _hostile_copy(folder: Path) -> Path:
    """Return an experiment with markup in the names of a muscle and a joint."""
    shutil.copytree(EXAMPLES / "planar_2r", folder)
    name = EVIL.replace("<", "&lt;")
    for file in (folder / "robot").glob("*.xml"):
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace("cable_1", name), encoding="utf-8")
    return folder


@pytest.mark.browser
def test_names_are_text_and_the_pointer_shows_newtons(page: Page, tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    file = tmp_path / "play.html"
    assert main(["play", str(_hostile_copy(tmp_path / "<i>arm")), "--html", str(file)]) == 0
    page.open(file.as_uri(), offline=True)
    page.wait_for("document.body && document.body.dataset.drawn")
    failure = "play.panel.failure = 'a long message about a step that failed. '.repeat(5)"
    page.resize(390, 844)
    page.evaluate(f"{failure}; play.panel.showStatus()")
    assert page.evaluate(OVERLAPS) == []
    page.evaluate("document.querySelector('[aria-label=help]').click()")
    assert page.evaluate(OVERLAPS) == []
    page.evaluate("document.querySelector('[aria-label=help]').click()")
    assert EVIL in page.evaluate("document.querySelector('.muscles').textContent")
    assert page.evaluate("typeof hit === 'undefined' && !document.querySelector('img, .title i')")

    page.resize(1000, 700)
    page.evaluate("dispatchEvent(new Event('resize'))")
    _point_at(
        page,
        "(p => [0, 1, 2].map(i => (p[i] + p[i + 3]) / 2))"
        "(play.shapes.find(s => s.name === 'muscles/cable_2').points.numbers)",
    )
    page.wait_for("!document.querySelector('.tip').hidden")
    assert page.evaluate("document.querySelector('.tip').textContent").startswith("cable_2: 10 N")
    for key, view, turn, tilt in (
        ("f", "front", -90, 0),
        ("s", "side", 0, 0),
        ("t", "top", -90, 90),
    ):
        for act in (
            f"dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }}))",
            f"querySelector('button[name=view-{view}]').click()",
        ):
            page.evaluate("play.camera.turn = play.camera.tilt = 1")
            page.evaluate("document.body." + act if "dispatch" in act else "document." + act)
            angles = page.evaluate("[play.camera.turn, play.camera.tilt]")
            np.testing.assert_allclose(np.degrees(angles), (turn, tilt), atol=1e-9)
    opened = "{ robotFile: 'my arm.urdf', path: 'experiment.toml', changes: ['controller.kd=30'] }"
    assert page.evaluate(f"Object.assign(play.data, {opened}), play.panel.command()") == (
        "cardsflow init 'my arm.urdf' -o experiment.toml && "
        "cardsflow run experiment.toml --set controller.kd=30"
    )
    page.evaluate("play.client.run(1500)")
    page.wait_for("document.body.dataset.drawn === '1.5'")
    colour = "play.shapes.find(s => s.name === `muscles/${m.name}`).colours.numbers[0]"
    reds = page.evaluate(f"play.client.setup.muscles.map(m => {colour})")
    tensions = page.evaluate("[...play.client.frame.tensions]")
    assert np.argmax(reds) == np.argmax(tensions)
    assert sorted(reds)[-2] < max(reds)  # only the largest tension has the last colour
    light = page.screenshot()[5:20, 400:420].mean()
    page.send(
        "Emulation.setEmulatedMedia",
        features=[{"name": "prefers-color-scheme", "value": "dark"}],
    )
    for part in ("body", ".panel", ".bar", ".help"):
        colour = f"getComputedStyle(document.querySelector('{part}')).color"
        assert page.evaluate(colour) == "rgb(230, 233, 238)", part
    assert page.screenshot()[5:20, 400:420].mean() < light - 100
    assert page.errors == []
