"""Makes the screens in docs/images that show runs: needs Chromium.

python docs/make_screens.py RESULTS_FOLDER [EXAMPLE ...]     (default: all examples)

Existing runs in the folder are used again. A screen is a page of `cardsflow view --html`,
`cardsflow play --html` or `cardsflow edit` in the browser of the tests.
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from PIL import Image  # noqa: E402
from support.browser import Page, opened_browser  # noqa: E402
from support.edit_page import served_editor  # noqa: E402

from cardsflow_fmu import Experiment, run  # noqa: E402
from cardsflow_fmu.results.report.page import report  # noqa: E402
from cardsflow_fmu.results.viewer.html.play_page import play_page  # noqa: E402
from cardsflow_fmu.results.viewer.view import run_act, write_html, write_page  # noqa: E402

IMAGES = ROOT / "docs" / "images"
SIZE, REPORT_SIZE = (1100, 720), (1100, 1500)
MAX_BYTES = 300_000


class Screen(NamedTuple):
    """An example at a moment.

    Attributes:
        time: In [s].
    """

    example: str
    time: float


SCREENS = (
    Screen("roboy_left_arm", 30.5),
    Screen("planar_2r", 6.3),
    Screen("hill_arm", 1.3),
    Screen("two_arms", 3.2),
    Screen("bicycle", 2.6),
)


PLAYED = (Screen("planar_2r", 1.5),)


def main() -> None:
    """Make the screens of some examples, or of all of them."""
    runs, wanted = Path(sys.argv[1]), sys.argv[2:]
    for screen in SCREENS:
        if not wanted or screen.example in wanted:
            see_replay(screen, runs)
    for screen in PLAYED:
        if not wanted or screen.example in wanted:
            see_play(screen, runs)
    if not wanted or "hill_arm" in wanted:
        see_edit("hill_arm", "triceps_lateral")
    if not wanted or "roboy_left_arm" in wanted:
        page = report(runs / "roboy_left_arm", runs / "report.html", overwrite=True)
        ready = "document.readyState === 'complete'"
        see(page, "report_roboy_left_arm.png", "", ready, REPORT_SIZE)


def see_replay(screen: Screen, runs: Path) -> None:
    """Make the screen of a replay."""
    folder = runs / screen.example
    if not folder.is_dir():
        run(Experiment.load(ROOT / "examples" / screen.example), folder)
    page = write_page([run_act(folder)], runs / f"{screen.example}.html", overwrite=True)
    see(page, f"view_{screen.example}.png", f"#t={screen.time}", "document.body?.dataset.drawn")


def see_play(screen: Screen, runs: Path) -> None:
    """Make the screen of a page that simulates."""
    experiment = Experiment.load(ROOT / "examples" / screen.example)
    page = write_html(play_page(experiment), runs / f"play_{screen.example}.html", overwrite=True)
    steps = round(screen.time / experiment.run.step)
    ready = f"document.body?.dataset.drawn && play.client.run({steps})"
    see(page, f"play_{screen.example}.png", "", ready)


def see_edit(example: str, muscle: str) -> None:
    """Make the screen of a page that edits muscles, with a selected muscle."""
    robot = ROOT / "examples" / example / "robot"
    with (
        tempfile.TemporaryDirectory() as profile,
        opened_browser(Path(profile), SIZE) as browser,
        served_editor(browser, robot),
    ):
        browser.evaluate(f"edit.select({{ muscle: {muscle!r}, point: 1 }})")
        browser.evaluate("new Promise(done => setTimeout(done, 1500))")
        save(browser, IMAGES / f"edit_{example}.png")


def see(page: Path, picture: str, fragment: str, ready: str, size: tuple[int, int] = SIZE) -> None:
    """Save a picture of a page in a browser without a network."""
    with tempfile.TemporaryDirectory() as profile, opened_browser(Path(profile), size) as browser:
        browser.open(page.as_uri() + fragment, offline=True)
        browser.wait_for(ready)
        browser.evaluate("new Promise(done => setTimeout(done, 1500))")
        save(browser, IMAGES / picture)


def save(browser: Page, file: Path) -> None:
    """Save the window as a small picture."""
    data, picture = io.BytesIO(), Image.fromarray(browser.screenshot().astype("uint8"))
    picture.save(data, "PNG", optimize=True)
    if data.tell() >= MAX_BYTES:
        data = io.BytesIO()
        picture.convert("RGB").quantize(256).save(data, "PNG", optimize=True)
    assert data.tell() < MAX_BYTES, f"{file}: {data.tell()} bytes"
    file.write_bytes(data.getvalue())
    print(file, data.tell())


if __name__ == "__main__":
    main()
