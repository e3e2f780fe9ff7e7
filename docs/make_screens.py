"""Makes the screens in docs/images that show runs: needs Chromium.

python docs/make_screens.py RESULTS_FOLDER      a folder for the runs; those that are there are kept

Every screen is a page of `cardsflow view --html`, seen by the browser that the tests use.
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

from cardsflow_fmu import Experiment, run  # noqa: E402
from cardsflow_fmu.results.report.page import report  # noqa: E402
from cardsflow_fmu.results.viewer.view import run_act, write_page  # noqa: E402

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


def main() -> None:
    """Make all of them."""
    runs = Path(sys.argv[1])
    for screen in SCREENS:
        folder = runs / screen.example
        if not folder.is_dir():
            run(Experiment.load(ROOT / "examples" / screen.example), folder)
        page = write_page([run_act(folder)], runs / f"{screen.example}.html")
        see(page, f"view_{screen.example}.png", f"#t={screen.time}", "document.body?.dataset.drawn")
    page = report(runs / "roboy_left_arm", runs / "report.html")
    see(page, "report_roboy_left_arm.png", "", "document.readyState === 'complete'", REPORT_SIZE)


def see(page: Path, picture: str, fragment: str, ready: str, size: tuple[int, int] = SIZE) -> None:
    """What a browser without a network shows of a page."""
    with tempfile.TemporaryDirectory() as profile, opened_browser(Path(profile), size) as browser:
        browser.open(page.as_uri() + fragment, offline=True)
        browser.wait_for(ready)
        browser.evaluate("new Promise(done => setTimeout(done, 1500))")
        save(browser, IMAGES / picture)


def save(browser: Page, file: Path) -> None:
    """The window as a picture that is small enough for a page of words."""
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
