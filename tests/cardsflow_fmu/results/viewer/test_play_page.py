"""Page that simulates: a user drags, clicks and types."""

import importlib.util
import io
import urllib.error
import urllib.request
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from support.browser import Page, opened_browser
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cli.common import parse_settings
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.results.viewer.live.page_server import page_server


def test_server_only_answers_requests_of_its_own_page() -> None:
    with page_server("<p>robot</p>") as server:
        address = server.address
        assert urllib.request.urlopen(address, timeout=5).read() == b"<p>robot</p>"
        port = int(address.rstrip("/").rpartition(":")[2])
        with pytest.raises(InputError, match=f"port {port} is used"), page_server("", port):
            pass
        for headers in ({"Origin": "http://example.org"}, {"Host": "example.org"}):
            with pytest.raises(urllib.error.HTTPError, match="403"):
                urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=5)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    with opened_browser(tmp_path_factory.mktemp("browser")) as page:
        yield page


def open_page(browser: Page, folder: Path, robot: str) -> None:
    """Open the page of `cardsflow play ROBOT --html` offline."""
    file = folder / "play.html"
    assert main(["play", str(EXAMPLES / robot), "--html", str(file)]) == 0
    assert file.stat().st_size < 700_000
    browser.open(file.as_uri(), offline=True)
    browser.wait_for("document.body && document.body.dataset.drawn")


def mouse(browser: Page, kind: str, place: list[float], button: str = "left") -> None:
    browser.send(
        "Input.dispatchMouseEvent",
        type=f"mouse{kind}",
        x=place[0],
        y=place[1],
        button=button,
        buttons=int(kind != "Released"),
        clickCount=1,
    )


def pixels(browser: Page, point: str) -> list[float]:
    """Return where a point of the scene, an expression, is in the window."""
    return browser.evaluate(
        "(() => { const canvas = document.querySelector('canvas');"
        " const { view } = play.camera.uniforms(canvas.clientWidth / canvas.clientHeight);"
        f" const [x, y] = project(view, {point});"
        " return [x * canvas.clientWidth, y * canvas.clientHeight]; })()"
    )


@pytest.mark.browser
def test_user_pulls_a_link_cuts_a_cable_and_steps_back(browser: Page, tmp_path: Path) -> None:
    open_page(browser, tmp_path, "planar_2r")
    browser.click("[value=joints]")
    browser.click("[aria-label=play]")
    browser.wait_for("play.client.frame.time > 0.2 && play.client.frame.mode === 'joints'")
    before = browser.evaluate("[...play.client.frame.tensions]")
    hand = pixels(browser, "play.handNow()")
    middle = pixels(browser, "play.handNow().map((x, i) => (x + play.pose(1)[9 + i]) / 2)")
    mouse(browser, "Pressed", middle)
    mouse(browser, "Moved", [middle[0] + 80, middle[1]])
    pull = "Math.hypot(...(play.client.frame.pull?.force ?? [0]))"
    browser.wait_for(f"{pull} > 1.0")
    tensions = "play.client.frame.tensions"
    browser.wait_for(f"{before}.some((f, i) => Math.abs(f - {tensions}[i]) > 1.0)")  # it resists
    labels = "[...document.querySelectorAll('.label:not([hidden])')].map(l => l.textContent)"
    browser.wait_for(f"{labels}.length === 1 && / N$/.test({labels}[0])")  # of the last drawn frame
    mouse(browser, "Released", hand)
    browser.wait_for("!play.client.frame.pull")
    browser.click("[aria-label='cut cable_1']")
    browser.wait_for("play.client.frame.tensions[0] === 0")
    browser.click("[aria-label=play]")
    browser.wait_for("!play.client.frame.playing")
    step = browser.evaluate("play.client.frame.step")
    browser.click("[aria-label='one step back']")
    browser.wait_for(f"play.client.frame.step === {step - 1}")
    assert browser.evaluate("play.panel.command()").endswith(
        "planar_2r --set plant.tension_scale.cable_1=0"
    )
    browser.evaluate(
        "(s => { s.value = 40; s.dispatchEvent(new Event('input')); })"
        "(document.querySelector('[aria-label=\"f_max of cable_1\"]'))"
    )
    browser.wait_for("'muscles.cable_1.f_max' in play.client.changes()")
    browser.evaluate("play.panel.setAll('mass', 1.5)")
    browser.evaluate("play.panel.setGains('kp', 0.5)")
    words = browser.evaluate("play.client.options(play.panel.settings())")
    _require_same_experiment(browser, tmp_path, words[1::2])
    assert not browser.errors


def _require_same_experiment(browser: Page, folder: Path, changes: list[str]) -> None:
    """Check that `Download experiment` contains the experiment with changes `key=value`."""
    browser.evaluate(
        "window.saved = null; URL.createObjectURL = blob => { saved = blob; return '#'; };"
        "[...document.querySelectorAll('button')]"
        ".find(b => b.textContent === 'Download experiment').click()"
    )
    browser.wait_for("saved || play.panel.failure", 20)
    assert browser.evaluate("play.panel.failure") == ""
    numbers = browser.evaluate("saved.arrayBuffer().then(b => Array.from(new Uint8Array(b)))")
    with zipfile.ZipFile(io.BytesIO(bytes(numbers))) as archive:
        assert archive.testzip() is None
        archive.extractall(folder / "downloaded")
    downloaded = Experiment.load(folder / "downloaded" / EXPERIMENT_FILE)
    expected = Experiment.load(EXAMPLES / "planar_2r", parse_settings(changes))
    assert len(changes) == 6
    actual, wanted = experiment_data(downloaded), experiment_data(expected)
    assert {**actual, "robot": None} == {**wanted, "robot": None}


@pytest.mark.browser
def test_user_drags_the_target_and_the_hand_follows(browser: Page, tmp_path: Path) -> None:
    open_page(browser, tmp_path, "roboy_left_arm")
    browser.click("[value=task]")
    browser.wait_for("play.client.frame.mode === 'task' && play.targetPoint()")
    browser.click("[aria-label=play]")
    place, target = pixels(browser, "play.targetPoint()"), browser.evaluate("play.targetPoint()")
    mouse(browser, "Pressed", place)
    for k in range(1, 6):
        mouse(browser, "Moved", [place[0] - 4 * k, place[1] - 2 * k])
    mouse(browser, "Released", place)
    start = browser.evaluate("play.client.frame.time")
    browser.wait_for(f"play.client.frame.time > {start + 2.5}")
    distance = "Math.hypot(...play.targetPoint().map((x, i) => x - play.handNow()[i]))"
    assert browser.evaluate(distance) < 1e-3  # in m
    assert browser.evaluate(f"Math.hypot(...{target}.map((x, i) => x - play.handNow()[i]))") > 0.01
    assert not browser.errors
