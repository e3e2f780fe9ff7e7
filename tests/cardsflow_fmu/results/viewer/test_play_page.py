"""Page that simulates: a user drags, clicks and types."""

import importlib.util
import io
import urllib.error
import urllib.request
import zipfile
from pathlib import Path

import numpy as np
import pytest
from support.browser import Page
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError, read_robot
from cardsflow_fmu.cli.common import parse_settings
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.experiment.experiment import EXPERIMENT_FILE, Experiment
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.results.viewer.live.page_server import page_server
from sim_dart import MusclePaths


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


def open_page(page: Page, folder: Path, robot: str, *options: str) -> None:
    """Open the page of `cardsflow play ROBOT --html` offline."""
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    file = folder / "play.html"
    assert main(["play", str(EXAMPLES / robot), *options, "--html", str(file)]) == 0
    assert file.stat().st_size < 700_000
    page.open(file.as_uri(), offline=True)
    page.wait_for("document.body && document.body.dataset.drawn")


def mouse(page: Page, kind: str, place: list[float], button: str = "left") -> None:
    page.send(
        "Input.dispatchMouseEvent",
        type=f"mouse{kind}",
        x=place[0],
        y=place[1],
        button=button,
        buttons=int(kind != "Released"),
        clickCount=1,
    )


def pixels(page: Page, point: str) -> list[float]:
    """Return where a point of the scene, an expression, is in the window."""
    return page.evaluate(
        "(() => { const canvas = document.querySelector('canvas');"
        " const { view } = play.camera.uniforms(canvas.clientWidth / canvas.clientHeight);"
        f" const [x, y] = project(view, {point});"
        " return [x * canvas.clientWidth, y * canvas.clientHeight]; })()"
    )


def _run_for(page: Page, seconds: float) -> None:
    """Simulate for a time, with a frame of every 10 ms: time does not depend on the machine."""
    runs = f"for (let k = 0; k < {round(100 * seconds)}; k++) await play.client.run(10);"
    page.evaluate(f"(async () => {{ {runs} }})()")


@pytest.mark.browser
def test_user_pulls_a_link_cuts_a_cable_and_steps_back(page: Page, tmp_path: Path) -> None:
    open_page(page, tmp_path, "planar_2r")
    page.click("[value=joints]")
    page.click("[aria-label=play]")
    page.wait_for("play.client.frame.time > 0.2 && play.client.frame.mode === 'joints'")
    before = page.evaluate("[...play.client.frame.tensions]")
    hand = pixels(page, "play.handNow()")
    middle = pixels(page, "play.handNow().map((x, i) => (x + play.pose(1)[9 + i]) / 2)")
    mouse(page, "Pressed", middle)
    mouse(page, "Moved", [middle[0] + 80, middle[1]])
    pull = "Math.hypot(...(play.client.frame.pull?.force ?? [0]))"
    page.wait_for(f"{pull} > 1.0")
    tensions = "play.client.frame.tensions"
    page.wait_for(f"{before}.some((f, i) => Math.abs(f - {tensions}[i]) > 1.0)")  # it resists
    labels = "[...document.querySelectorAll('.label:not([hidden])')].map(l => l.textContent)"
    page.wait_for(f"{labels}.length === 1 && / N$/.test({labels}[0])")  # of the last drawn frame
    mouse(page, "Released", hand)
    page.wait_for("!play.client.frame.pull")
    page.click("[aria-label='cut cable_1']")
    page.wait_for("play.client.frame.tensions[0] === 0")
    page.click("[aria-label=play]")
    page.wait_for("!play.client.frame.playing")
    cut = page.evaluate("play.client.changes()['plant.break_time.cable_1']")
    step = page.evaluate("play.client.frame.step")
    page.click("[aria-label='one step back']")
    page.wait_for(f"play.client.frame.step === {step - 1}")
    assert page.evaluate("play.panel.command()").endswith(
        f"planar_2r --set plant.break_time.cable_1={cut!r}"
    )
    page.evaluate(
        "(s => { s.value = 40; s.dispatchEvent(new Event('input')); })"
        "(document.querySelector('[aria-label=\"f_max of cable_1\"]'))"
    )
    page.wait_for("'muscles.cable_1.f_max' in play.client.changes()")
    page.evaluate("play.panel.setAll('mass', 1.5)")
    page.evaluate("play.panel.setGains('kp', 0.5)")
    words = page.evaluate("play.client.options(play.panel.settings())")
    _require_same_experiment(page, tmp_path, words[1::2])
    assert not page.errors


@pytest.mark.browser
def test_arm_copes_with_a_cut_cable(page: Page, tmp_path: Path) -> None:
    """The fault is found and shown, the cable ends early, and the hand stays on its path."""
    settings = "faults.react=true", "estimator.encoder_noise=1e-4", "run.duration=3"
    options = [word for setting in settings for word in ("--set", setting)]
    open_page(page, tmp_path, "roboy_left_arm", *options)
    line = "play.shapes.find(shape => shape.name === 'muscles/motor4').points.numbers"
    length = f"(p => p.slice(3).reduce((l, x, i) => l + Math.abs(x - p[i]), 0))([...{line}])"
    whole = page.evaluate(length)
    _run_for(page, 0.3)
    page.evaluate("document.querySelector(\"[aria-label='cut motor4']\").click()")
    page.wait_for("'plant.break_time.motor4' in play.client.changes()")
    cut = page.evaluate("play.client.changes()['plant.break_time.motor4']")
    _run_for(page, 1.0)
    page.wait_for("document.querySelectorAll('.faults div').length === 2")
    texts = page.evaluate("[...document.querySelectorAll('.faults div')].map(d => d.textContent)")
    assert texts[0].endswith(" s muscle motor4: broken")
    assert texts[1].endswith(" s decision: continue")
    assert cut <= float(texts[0].split()[0]) + 1e-3 <= cut + 0.1
    assert page.evaluate("[...document.querySelectorAll('.mark')].map(m => m.title)") == texts
    assert page.evaluate(length) < 0.7 * whole
    value = "play.client.frame.values[play.panel.analysis.columns.get(`{}.hand.${{axis}}`)]"
    error = f"{value.format('plant.y')} - {value.format('reference.y_d')}"
    assert page.evaluate(f"Math.hypot(...['x', 'y', 'z'].map(axis => {error}))") < 5e-3
    page.evaluate(f"document.querySelector(\".mark[title='{texts[0]}']\").click()")
    # the mark goes back to the fault
    page.wait_for(f"Math.abs(play.client.frame.time - {texts[0].split()[0]}) < 1e-3")
    assert not page.errors


@pytest.mark.browser
def test_cable_is_not_cut_in_the_past(page: Page, tmp_path: Path) -> None:
    """A busy page shows an earlier time than that of the simulation, which the command repeats."""
    open_page(page, tmp_path, "planar_2r")
    page.evaluate("play.client.stepOnce(100)")
    page.evaluate("play.client.set('plant.break_time.cable_1', 0.02)")
    time = page.evaluate("play.client.frame.time")
    assert time > 0.02
    assert page.evaluate("play.client.changes()") == {"plant.break_time.cable_1": time}
    page.evaluate("play.client.stepOnce(1)")
    assert page.evaluate("play.client.frame.tensions[0]") == 0


def _require_same_experiment(page: Page, folder: Path, changes: list[str]) -> None:
    """Check that `Download experiment` contains the experiment with changes `key=value`."""
    page.evaluate(
        "window.saved = null; URL.createObjectURL = blob => { saved = blob; return '#'; };"
        "[...document.querySelectorAll('button')]"
        ".find(b => b.textContent === 'Download experiment').click()"
    )
    page.wait_for("saved || play.panel.failure", 20)
    assert page.evaluate("play.panel.failure") == ""
    numbers = page.evaluate("saved.arrayBuffer().then(b => Array.from(new Uint8Array(b)))")
    with zipfile.ZipFile(io.BytesIO(bytes(numbers))) as archive:
        assert archive.testzip() is None
        archive.extractall(folder / "downloaded")
    downloaded = Experiment.load(folder / "downloaded" / EXPERIMENT_FILE)
    expected = Experiment.load(EXAMPLES / "planar_2r", parse_settings(changes))
    assert len(changes) == 6
    actual, wanted = experiment_data(downloaded), experiment_data(expected)
    assert {**actual, "robot": None} == {**wanted, "robot": None}


@pytest.mark.browser
def test_user_drags_the_target_and_the_hand_follows(page: Page, tmp_path: Path) -> None:
    open_page(page, tmp_path, "roboy_left_arm")
    page.click("[value=task]")
    page.wait_for("play.client.frame.mode === 'task' && play.targetPoint()")
    page.click("[aria-label=play]")
    place, target = pixels(page, "play.targetPoint()"), page.evaluate("play.targetPoint()")
    mouse(page, "Pressed", place)
    for k in range(1, 6):
        mouse(page, "Moved", [place[0] - 4 * k, place[1] - 2 * k])
    mouse(page, "Released", place)
    start = page.evaluate("play.client.frame.time")
    page.wait_for(f"play.client.frame.time > {start + 2.5}")
    distance = "Math.hypot(...play.targetPoint().map((x, i) => x - play.handNow()[i]))"
    assert page.evaluate(distance) < 1e-3  # in m
    assert page.evaluate(f"Math.hypot(...{target}.map((x, i) => x - play.handNow()[i]))") > 0.01
    assert not page.errors


@pytest.mark.browser
def test_joint_sliders_of_a_robot_show_its_lengths(page: Page, tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("no ziglang: the extra `cross`")
    folder = EXAMPLES / "hill_arm/robot"
    assert main(["view", str(folder), "--html", str(tmp_path / "arm.html")]) == 0
    page.open((tmp_path / "arm.html").as_uri(), offline=True)
    page.wait_for("document.body?.dataset.drawn")
    page.evaluate(
        "(s => { s.value = 1; s.dispatchEvent(new Event('input')); })"
        "(document.querySelectorAll('.targets input')[1])"
    )
    q = [page.evaluate("play.client.frame.q[0]"), 1.0]
    expected = MusclePaths(read_robot(folder)).evaluate(q).lengths
    cells = "[...document.querySelectorAll('.muscles td:nth-child(2)')].map(c => +c.textContent)"
    page.wait_for(f"Math.abs({cells}[2] - {expected[2]}) < 1e-4")
    np.testing.assert_allclose(page.evaluate(cells)[: len(expected)], expected, rtol=1e-3)
    assert page.evaluate("document.querySelector('.bar')") is None
    assert page.errors == []
