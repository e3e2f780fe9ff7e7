from __future__ import annotations

import base64
import json
import re
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import Page
from support.recorded import sinusoidal_result, with_columns
from support.robots.robots import EXAMPLES, planar_2r

from addin_sdfusion.robot import InputError, Robot, read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.models.browser import pack
from cardsflow_fmu.results.viewer import Motion, Stage, motion_of
from cardsflow_fmu.results.viewer.html.page import replay_page
from cardsflow_fmu.results.viewer.html.play_page import play_page
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.act import Act
from cardsflow_fmu.results.viewer.view import write_page

PICTURES = True


def roboy() -> Robot:
    return read_robot(EXAMPLES / "roboy_left_arm/robot")


def act(robot: Robot, seconds: float, title: str = "waving") -> Act:
    result = sinusoidal_result(robot, seconds)
    loop = 0.1 * np.stack([np.cos(result["time"]), np.sin(result["time"]), 0 * result["time"]])
    names = [f"y_d.{robot.task_frames[0].name}.{axis}" for axis in "xyz"]
    motion = motion_of(robot, with_columns(result, dict(zip(names, loop, strict=True))))
    return Act(Stage(robot, motion), title, ("RMS tracking error 1 m",))


@pytest.fixture(scope="module")
def half_a_minute() -> Act:
    return act(roboy(), 30.0)


def decode_page(page: str) -> tuple[dict[str, Any], Any]:
    """Return the header, and a function that decodes tables as the script of the page."""
    text = re.search(r'id="motion">([^<]*)<', page)
    data = zlib.decompress(base64.b64decode(text[1]))
    (length,) = struct.unpack_from("<I", data)
    low, high = np.frombuffer(data[4 + length :], np.uint8).reshape(2, -1).astype(np.uint16)
    numbers = low + (high << 8)

    def table(entry: dict[str, Any]) -> np.ndarray:
        part = numbers[entry["at"] :][: entry["rows"] * entry["columns"]]
        levels = np.cumsum(part.reshape(entry["columns"], -1).T, axis=0, dtype=np.uint16)
        return entry["low"] + levels * (entry["high"] - entry["low"]) / 65535

    return json.loads(data[4 : 4 + length]), table


@pytest.mark.slow
def test_page_contains_the_scene_of_every_frame(half_a_minute: Act) -> None:
    stage = half_a_minute.stage
    header, table = decode_page(replay_page([half_a_minute]))
    (shown,) = header["acts"]
    np.testing.assert_allclose(shown["time"], stage.motion.time, atol=1e-6)
    for k in (0, 333, len(stage) - 1):
        for shape, data in zip(stage.scene(k), shown["shapes"], strict=True):
            assert data["name"] == shape.name
            points = table(data["points"])
            if isinstance(shape, s.Trail):
                count = int(table(data["values"])[k if data["values"]["rows"] > 1 else 0, 0])
                points = points[:count]
            else:
                points = points[min(k, len(points) - 1)].reshape(-1, 3)
            np.testing.assert_allclose(points, shape.points, atol=5e-5 * stage.reach)
            colours = table(data["colours"])
            np.testing.assert_allclose(colours[min(k, len(colours) - 1)], shape.colour, atol=0.01)


@pytest.mark.slow
def test_page_of_30_s_with_11_muscles_is_below_3_megabytes(half_a_minute: Act) -> None:
    assert len(replay_page([half_a_minute])) < 1_000_000


def test_page_has_no_external_address_and_escapes_names() -> None:
    hostile = "</script><img src=http://example.org onerror=alert(1)>"
    page = replay_page([act(planar_2r(), 0.1, hostile)])
    assert re.findall(r"\b(?:https?|wss?|ftp):", page) == ["http:"]  # the title's, escaped
    assert "<img" not in page
    assert "default-src 'none'" in page


def test_play_page_states_first_that_it_has_no_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pack, "wasm_module", lambda: b"module")
    header, _ = decode_page(play_page(Experiment.load(EXAMPLES / "pick_up")))
    (shown,) = header["acts"]
    assert "simulates no ground, objects and contacts" in shown["notes"][0]


def test_equal_runs_have_equal_pages() -> None:
    assert replay_page([act(planar_2r(), 1.0)]) == replay_page([act(planar_2r(), 1.0)])


def test_page_that_cannot_be_written_is_an_input_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_page([act(planar_2r(), 0.1)], tmp_path / "file/page.html")


def picture(page: Page) -> np.ndarray:
    """Return the part of the window that only shows the robot."""
    page.wait_for("document.body?.dataset.drawn !== undefined")
    return page.screenshot()[120:620, 20:640]


def colourful(image: np.ndarray) -> int:
    """Return the number of pixels that are not grey; background, floor and links are grey."""
    return int(np.count_nonzero(np.ptp(image, axis=2) > 60))


@pytest.mark.browser
def test_page_opens_from_disk_without_a_network_and_plays(page: Page, tmp_path: Path) -> None:
    shown = act(roboy(), 10.0)  # longer than a pause of this process
    file = write_page([shown], tmp_path / "a name with spaces.html")
    page.open(file.as_uri(), offline=True)
    first = picture(page)
    assert colourful(first) > 1000

    page.click("button[aria-label=play]")
    pause = "document.querySelector('button[aria-label=play]').click()"  # before the run ends
    page.wait_for(f"Number(document.body.dataset.drawn) > 0.5 && ({pause}, true)")
    moved = picture(page)
    assert np.count_nonzero(np.abs(moved - first).max(axis=2) > 40) > 500
    drawn = page.evaluate("document.body.dataset.drawn")
    page.evaluate("new Promise(done => setTimeout(done, 200))")
    assert page.evaluate("document.body.dataset.drawn") == drawn

    assert page.evaluate("[...document.querySelectorAll('.label')].every(l => l.hidden)")
    page.evaluate("document.querySelector('input[name=\"joint values\"]').click()")
    page.wait_for("!document.querySelector('.label').hidden")
    label = page.evaluate("document.querySelector('.label').textContent")
    k = int(np.searchsorted(shown.stage.motion.time, float(drawn)))
    assert float(label.split(": ")[1]) == pytest.approx(shown.stage.motion.q[k, 0], abs=0.05)

    for name in s.GROUPS:
        page.evaluate(f"document.querySelector('input[name=\"{name}\"]:checked')?.click()")
    page.show_changes()
    assert colourful(picture(page)) < 100
    assert page.evaluate("[...document.querySelectorAll('.label')].every(l => l.hidden)")

    assert page.errors == []
    assert page.requests == [file.as_uri()]


@pytest.mark.browser
def test_page_shows_two_runs_side_by_side_and_no_control_bar_for_a_robot(
    page: Page, tmp_path: Path
) -> None:
    robot = planar_2r()
    file = write_page([act(robot, 2.0), act(robot, 3.0, "longer")], tmp_path / "two.html")
    page.open(f"{file.as_uri()}#t=2.5", offline=True)
    both = picture(page)
    assert page.evaluate("document.querySelectorAll('.act').length") == 2
    assert "2.50 of 3.00 s" in page.evaluate("document.querySelector('.bar output').textContent")
    assert colourful(both[:, :300]) > 500
    assert colourful(both[:, 340:]) > 500

    file = write_page(
        [Act(Stage(robot, Motion.still([0.5, 0.5])), "still")], tmp_path / "still.html"
    )
    page.open("about:blank")
    page.open(file.as_uri(), offline=True)
    picture(page)
    assert page.evaluate("document.querySelector('.bar') === null")
    assert page.errors == []


@pytest.mark.browser
def test_panels_follow_the_cursor(page: Page, tmp_path: Path) -> None:
    robot = roboy()
    shown = act(robot, 2.0)
    file = write_page([shown], tmp_path / "page.html")
    page.open(file.as_uri(), offline=True)
    picture(page)
    page.resize(1400, 900)
    page.evaluate("document.querySelector('.panel').open = true")
    page.wait_for("document.querySelector('.plot canvas').clientWidth > 100")
    before = page.evaluate("document.querySelector('.plot-values output').textContent")
    page.click(".plot canvas")  # its middle
    page.wait_for("Math.abs(Number(document.body.dataset.drawn) - 1.0) < 0.02")
    shows = "document.querySelector('.plot-values output').textContent"
    page.wait_for(f"{shows} !== {before!r}", 20.0)  # numbers change at 10 Hz
    k = int(np.searchsorted(shown.stage.motion.time, 1.0))
    force = page.evaluate("Number(document.querySelector('.muscles td:nth-child(2)').textContent)")
    assert force == pytest.approx(shown.stage.motion.tensions[k, 0], rel=0.1)
    for view, turn, tilt in (("front", -90, 0), ("side", 0, 0), ("top", -90, 90)):
        page.click(f"button[name=view-{view}]")
        angles = page.evaluate("[window.camera.turn, window.camera.tilt]")
        np.testing.assert_allclose(np.degrees(angles), (turn, tilt), atol=1e-9)
    assert page.errors == []


@pytest.mark.browser
def test_pointer_shows_name_and_newtons_of_a_muscle(page: Page, tmp_path: Path) -> None:
    shown = act(planar_2r(), 1.0)
    file = write_page([shown], tmp_path / "page.html")
    page.open(file.as_uri(), offline=True)
    picture(page)
    points = shown.stage.scene(0)
    line = next(shape for shape in points if shape.name == "muscles/cable_2").points
    x, y = page.evaluate(
        "(p => { const { clientWidth, clientHeight } = document.querySelector('.act');"
        "const { view } = window.camera.uniforms(clientWidth / clientHeight);"
        "const place = project(view, p);"
        "return [place[0] * clientWidth, place[1] * clientHeight]; })"
        f"({line.mean(axis=0).tolist()})"
    )
    page.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    page.wait_for("!document.querySelector('.tip').hidden")
    text = page.evaluate("document.querySelector('.tip').textContent")
    assert re.match(r"cable_2: [\d.]+ N", text), text
