"""Page that edits muscles: a user clicks, drags and types."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import NO_DRAWING, Page, opened_browser
from support.edit_page import served_editor
from support.robots.every_field import robot_of_every_field

from addin_sdfusion.muscles.mirror import other_side
from addin_sdfusion.robot import read_robot
from addin_sdfusion.robot.formats.muscle_table.document import MuscleDocument
from addin_sdfusion.robot.formats.muscle_table.write import table_text
from addin_sdfusion.robot.formats.read import read
from cardsflow_fmu.cli.main import main
from cardsflow_fmu.results.viewer.html.edit_page import edit_page

OVERLAPS = (Path(__file__).parent / "overlaps.js").read_text(encoding="utf-8")
EVIL = "<img src=x onerror=hit=1></script><script>hit=1</script>"
LAWS = {
    "ideal": [],
    "elastic_cable": [{"name": "k", "unit": "N/m", "default": 1e3, "lower": 0.0, "upper": None}],
}


def link(name: str, mass: float, size: float) -> str:
    """Return a link of a URDF file."""
    inertia = " ".join(f'i{xx}="{0.01 * mass * size}"' for xx in ("xx", "yy", "zz"))
    return (
        f'<link name="{name}"><inertial><origin xyz="0 0 {size / 2}"/><mass value="{mass}"/>'
        f'<inertia {inertia} ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def joint(name: str, parent: str, child: str, height: float, limits: str) -> str:
    """Return a revolute joint about the y axis."""
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0 0 {height}"/><axis xyz="0 1 0"/><limit {limits} effort="50" '
        'velocity="5"/></joint>'
    )


def write_arm(folder: Path, base: str = "base") -> Path:
    """Write an arm with two joints and no muscles."""
    parts = (
        *(link(base, 3.0, 0.3), link("upper", 1.2, 0.3), link("fore", 0.8, 0.26)),
        '<link name="hand"/>',
        joint("shoulder", base, "upper", 0.35, 'lower="-1.2" upper="1.4"'),
        joint("elbow", "upper", "fore", 0.3, 'lower="0" upper="2.2"'),
        '<joint name="wrist" type="fixed"><parent link="fore"/><child link="hand"/>'
        '<origin xyz="0 0 0.26"/></joint>',
    )
    file = folder / "arm.urdf"
    file.write_text(f'<robot name="arm">{"".join(parts)}</robot>', encoding="utf-8")
    return file


def session(file: Path, name: str = "arm") -> dict[str, Any]:
    """Return the session of a page from disk."""
    document = MuscleDocument.of(read(file).require()).to_plain()
    return {
        **{"name": name, "document": document, "laws": LAWS, "files": {}},
        **{"token": None, "digest": ""},
    }


def test_page_contains_hostile_names_only_as_data(tmp_path: Path) -> None:
    file = write_arm(tmp_path, EVIL.replace("<", "&lt;").replace(">", "&gt;"))
    robot = read(file).require()
    page = edit_page(robot, tmp_path, session(file, EVIL))
    assert EVIL not in page
    assert "<img" not in page
    assert "connect-src" not in page
    data = json.loads(page.split('id="edit">')[1].split("</script>")[0])
    assert EVIL in data["poses"]
    np.testing.assert_allclose(data["poses"]["fore"][9:], (0.0, 0.0, 0.65))
    shoulder, elbow = data["axes"]
    assert (shoulder["link"], shoulder["child"], elbow["link"]) == (EVIL, "upper", "upper")
    np.testing.assert_allclose(elbow["position"], (0.0, 0.0, 0.3))
    np.testing.assert_allclose(elbow["direction"], (0.0, 1.0, 0.0))


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with opened_browser(tmp_path_factory.mktemp("browser"), (1400, 900)) as page:
        page.run_first(NO_DRAWING)
        yield page


class Hand:
    """A user's hand on the mouse and the keyboard."""

    def __init__(self, page: Page) -> None:
        self.page = page

    def pixel(self, link: str, position: tuple[float, float, float]) -> list[float]:
        """Return where a point of a link is in the window."""
        return self.page.evaluate(f"edit.pixelOf(toWorld(edit.poses[{link!r}], {list(position)}))")

    def mouse(self, kind: str, place: list[float], buttons: int = 0) -> None:
        """Send a mouse event."""
        self.page.send(
            "Input.dispatchMouseEvent",
            type=f"mouse{kind}",
            x=place[0],
            y=place[1],
            button="left",
            buttons=buttons,
            clickCount=1,
        )

    def click(self, place: list[float]) -> None:
        """Click a place in the window."""
        self.mouse("Moved", place)
        self.mouse("Pressed", place, 1)
        self.mouse("Released", place)

    def drag(self, begin: list[float], end: list[float]) -> None:
        """Drag from a place to another one."""
        self.mouse("Moved", begin)
        self.mouse("Pressed", begin, 1)
        for part in (0.5, 1.0):
            self.mouse("Moved", [a + part * (b - a) for a, b in zip(begin, end, strict=True)], 1)
        self.mouse("Released", end)

    def key(self, key: str, *, control: bool = False) -> None:
        """Press a key."""
        self.page.evaluate(
            f"document.body.dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', "
            f"bubbles: true, ctrlKey: {str(control).lower()} }}))"
        )

    def choose(self, title: str, value: str) -> None:
        """Choose an option of a list."""
        self.page.show_changes()
        self.page.evaluate(
            f"(s => {{ s.value = {value!r}; s.dispatchEvent(new Event('change')); }})"
            f"(document.querySelector('select[aria-label=\"{title}\"]'))"
        )

    def enter(self, title: str, text: str) -> None:
        """Type into a field."""
        self.page.show_changes()
        self.page.evaluate(
            f"(i => {{ i.value = {text!r}; i.dispatchEvent(new Event('input')); "
            "i.dispatchEvent(new Event('change')); })"
            f"(document.querySelector('input[aria-label=\"{title}\"]'))"
        )

    def document(self) -> dict[str, Any]:
        """Return the document."""
        self.page.show_changes()
        return json.loads(self.page.evaluate("JSON.stringify(edit.document.data)"))

    def muscle(self, *points: tuple[str, tuple[float, float, float]]) -> None:
        """Add a muscle by clicks on the links."""
        self.key("n")
        for name, position in points:
            self.click(self.pixel(name, position))
        self.key("Enter")

    def surface(self, shape: str, name: str, position: tuple[float, float, float]) -> None:
        """Add a wrap surface by a click."""
        self.choose("add a wrap surface", shape)
        self.click(self.pixel(name, position))


def open_page(browser: Page, folder: Path, base: str = "base", name: str = "arm") -> Hand:
    """Open the page of an arm offline."""
    file, page = write_arm(folder, base), folder / "edit.html"
    text = edit_page(read(file).require(), folder, session(file, name))
    page.write_text(text, encoding="utf-8")
    assert page.stat().st_size < 300_000
    browser.evaluate(
        "window.edit && edit.document.markSaved()"
    )  # else the page asks before it closes
    browser.open(page.as_uri(), offline=True)
    browser.wait_for("document.body && document.body.dataset.drawn")
    return Hand(browser)


@pytest.mark.browser
def test_user_edits_points_and_surfaces_and_undoes_everything(
    browser: Page, tmp_path: Path
) -> None:
    hand = open_page(browser, tmp_path)
    start = hand.document()
    hand.muscle(("base", (0.0, 0.0, 0.2)), ("upper", (0.0, 0.0, 0.2)))
    hand.surface("cylinder", "upper", (0.0, 0.0, 0.3))
    document = hand.document()
    (muscle,), (wrap,) = document["muscles"], document["wraps"]
    assert [p["link"] for p in muscle["points"]] == ["base", "upper"]
    radius = browser.evaluate("edit.linkShapes.find(s => s.kind === 'Capsule').radius")
    for point in muscle["points"]:  # on the surface of the capsule, where it was clicked
        np.testing.assert_allclose(np.hypot(*point["position"][:2]), radius, rtol=1e-3)
        np.testing.assert_allclose(point["position"][2], 0.2, atol=radius)
    axis = browser.evaluate("edit.frameOf(edit.document.data.wraps[0]).axes[2]")
    np.testing.assert_allclose(np.abs(axis), (0.0, 1.0, 0.0), atol=1e-5)  # the joint axis
    np.testing.assert_allclose(wrap["position"], 0.0, atol=1e-6)

    ends = browser.evaluate("edit.shapesOf.handles.map(h => [h.part, edit.pixelOf(h.place)])")
    handles = {part: place for part, place in ends if part}
    hand.drag(handles["x"], [handles["x"][0] + 30.0, handles["x"][1]])
    assert hand.document()["wraps"][0]["radius"] > 1.2 * wrap["radius"]
    hand.muscle(("upper", (0.0, 0.0, 0.1)), ("fore", (0.0, 0.0, 0.2)))
    hand.choose("route over a surface", "cylinder_1")
    hand.choose("side of the surface", "-1")
    expected = {"surface": "cylinder_1", "segment": 0, "side": -1}
    assert hand.document()["muscles"][1]["wraps"] == [expected]
    hand.choose("link of the point", "hand")
    point = hand.document()["muscles"][1]["points"][1]
    assert point["link"] == "hand"
    np.testing.assert_allclose(point["position"][2], -0.06, atol=radius)
    hand.enter("position of the point x", "0,05")
    assert hand.document()["muscles"][1]["points"][1]["position"][0] == 0.05
    hand.enter("name of the muscle", "triceps_l")
    hand.choose("muscle law", "elastic_cable")
    hand.enter("k (0 to ∞)", "-1")
    assert hand.document()["muscles"][1]["parameters"] == {"k": 1000}
    hand.key("m")
    muscles = hand.document()["muscles"]
    assert [m["name"] for m in muscles] == ["muscle_1", "triceps_l", "triceps_r"]
    before, image = (np.array([p["position"] for p in m["points"]]) for m in muscles[1:])
    np.testing.assert_allclose(image, before * (1.0, -1.0, 1.0), atol=2e-6)
    assert muscles[2]["wraps"][0]["side"] == 1
    hand.key("Delete")
    assert len(hand.document()["muscles"]) == 2
    words = ("arm_l", "left_arm", "ArmRight", "LArm", "torso", "R_2", "hall", "shoulder.Left")
    found = browser.evaluate(f"{list(words)}.map(otherSide)")
    assert found == [other_side(word) for word in words]

    browser.click("[aria-label=save]")
    text = browser.evaluate("document.querySelector('.dialog pre').textContent")
    document = MuscleDocument.from_plain(hand.document())
    assert text == f"{table_text(document)}\n"
    document = MuscleDocument.of(robot_of_every_field(0))
    written = browser.evaluate(f"muscleTableText({json.dumps(document.to_plain())})")
    assert written == table_text(document)
    hand.key("Escape")
    for _ in range(browser.evaluate("edit.document.past.length") + 1):
        hand.key("z", control=True)
    assert hand.document() == start
    assert not browser.evaluate("edit.document.isChanged")
    hand.key("y", control=True)
    assert len(hand.document()["muscles"]) == 1
    hand.key("z", control=True)
    assert not browser.errors


def _resize(page: Page, width: int, height: int) -> None:
    page.send(
        "Emulation.setDeviceMetricsOverride",
        width=width,
        height=height,
        deviceScaleFactor=1,
        mobile=False,
    )


@pytest.mark.browser
def test_no_texts_overlap_and_hostile_names_stay_text(browser: Page, tmp_path: Path) -> None:
    hand = open_page(browser, tmp_path, EVIL.replace("<", "&lt;").replace(">", "&gt;"), EVIL)
    hand.muscle((EVIL, (0.0, 0.0, 0.2)), ("upper", (0.0, 0.0, 0.1)), ("fore", (0.0, 0.0, 0.1)))
    hand.surface("ellipsoid", "upper", (0.0, 0.0, 0.3))
    hand.enter("name of the wrap surface", EVIL)
    muscle = browser.evaluate("edit.selected.muscle")
    browser.evaluate("edit.select({ muscle: edit.selected.muscle })")
    height = "edit.document.data.wraps[0].half_axes[1]"
    for part, selected in ((2.0, None), (0.8, EVIL)):  # beside the ellipsoid, and on it
        frame = "edit.frameOf(edit.document.data.wraps[0])"
        place = f"(({{ centre, axes }}) => sum(centre, axes[2], {part} * {height}))({frame})"
        sideways = f"sum({place}, [{0.08 if selected is None else 0.0}, 0, 0])"
        hand.click(browser.evaluate(f"edit.pixelOf({sideways})"))
        assert browser.evaluate("edit.selected.wrap") == selected
    assert browser.evaluate("[edit.selected.wrap, edit.selected.muscle]") == [EVIL, muscle]
    hand.choose("route over a surface", EVIL)
    hand.enter("name of the muscle", EVIL)
    browser.evaluate("edit.select({ muscle: edit.selected.muscle, point: 1, wrap: null })")
    browser.evaluate("edit.fail('a long message about a step that failed. '.repeat(5))")
    browser.evaluate("edit.selected.wrap = edit.document.data.wraps[0].name; edit.redraw()")
    for size in ((1400, 900), (1024, 768), (390, 844)):
        _resize(browser, *size)
        for is_open in ("true", "false"):
            browser.evaluate(f"document.querySelector('.panel').open = {is_open}")
            browser.show_changes()
            for top in (0, 400, 9999):
                browser.evaluate(f"document.querySelector('.panel').scrollTop = {top}")
                assert browser.evaluate(OVERLAPS) == [], (size, is_open, top)
        for part in ("save", "help"):
            browser.evaluate(f"document.querySelector('[aria-label={part}]').click()")
            assert browser.evaluate(OVERLAPS) == [], (size, part)
            hand.key("Escape")
    assert EVIL in browser.evaluate("document.querySelector('.panel').textContent")
    assert browser.evaluate("typeof hit === 'undefined' && !document.querySelector('img')")
    for _ in range(browser.evaluate("edit.document.past.length")):
        hand.key("z", control=True)
    assert not browser.errors


@pytest.mark.browser
def test_arm_gets_six_muscles_by_clicks_and_drags_and_tracks(browser: Page, tmp_path: Path) -> None:
    file = write_arm(tmp_path)
    _resize(browser, 1000, 700)
    with served_editor(browser, file):
        hand = Hand(browser)
        hand.surface("cylinder", "upper", (0.0, 0.0, 0.3))
        # begin and end of each muscle, and the side of the axes
        pairs = (
            *(("base", 0.25, "upper", 0.06, 1.0), ("base", 0.22, "upper", 0.09, -1.0)),
            *(("upper", 0.13, "fore", 0.06, 1.0), ("upper", 0.16, "fore", 0.1, -1.0)),
            *(("base", 0.18, "fore", 0.14, 1.0), ("base", 0.15, "fore", 0.18, -1.0)),
        )
        for k, (first, low, last, high, side) in enumerate(pairs):
            browser.click("[aria-label='new muscle']")
            hand.click(hand.pixel(first, (0.0, 0.0, low)))
            if k == 3:
                hand.click(hand.pixel("upper", (-0.03, 0.0, 0.3)))
            hand.click(hand.pixel(last, (0.0, 0.0, high)))
            browser.click("[aria-label='new muscle']")
            for i in (0, 1):
                place = f"edit.worldOf(edit.document.data.muscles[{k}].points[{i}])"
                ends = f"[0, {0.045 * side}].map(x => edit.pixelOf(sum({place}, [x, 0, 0])))"
                hand.drag(*browser.evaluate(ends))
        for (first, _, last, _, side), muscle in zip(
            pairs, hand.document()["muscles"], strict=True
        ):
            assert [point["link"] for point in muscle["points"]] == [first, last]
            for point in muscle["points"]:
                np.testing.assert_allclose(point["position"][0], 0.045 * side, atol=0.006)
        browser.wait_for("edit.result.arms.muscle_4 && !edit.server.isBusy")
        expected = [{"surface": "cylinder_1", "segment": 0, "side": 0}]
        assert hand.document()["muscles"][3]["wraps"] == expected
        assert browser.evaluate("edit.result.error") == ""
        browser.show_changes()
        warning = browser.evaluate("document.querySelector('.edit .bound').textContent")
        assert warning.startswith("The moment arm changes sign about shoulder at ")  # muscle 6

        before = browser.evaluate("edit.result.lengths.get('muscle_3')")
        height = browser.evaluate("edit.poses.hand[11]")
        browser.evaluate("edit.setJoint(1, 0.5)")
        browser.wait_for(f"edit.poses.hand[11] < {height} - 0.01")
        assert browser.evaluate("edit.result.lengths.get('muscle_3')") < before - 0.01
        assert browser.evaluate("edit.result.paths.get('muscle_4').length") > 2  # on the cylinder

        (tmp_path / "muscles.csv").write_text("name,frame,link,x [m],y [m],z [m]\n")
        browser.click("[aria-label=save]")
        dialog = "document.querySelector('.dialog')"
        browser.wait_for(f"/reload the page/.test({dialog}.textContent)", 30.0)
        assert not browser.evaluate(f"{dialog}.textContent.includes('Write')")
        hand.key("Escape")
        (tmp_path / "muscles.csv").unlink()
        browser.click("[aria-label=save]")
        browser.wait_for("document.querySelector('.dialog .main')?.textContent === 'Write'", 30.0)
        browser.click(".dialog .main")
        browser.wait_for("!edit.document.isChanged", 30.0)
        document = MuscleDocument.from_plain(hand.document())
    assert (tmp_path / "muscles.csv").read_text() == table_text(document)
    assert browser.errors == []
    run = tmp_path / "experiment.toml"
    assert main(["init", str(file), "-o", str(run)]) == 0
    assert main(["run", str(run), "-o", str(tmp_path / "results")]) == 0
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["tracking"]["rms"] < 1e-3
    robot = read_robot(file)
    assert len(robot.muscles) == 6
    assert not robot.motors  # the muscles alone have moved the arm
