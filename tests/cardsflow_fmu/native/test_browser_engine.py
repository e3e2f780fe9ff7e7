"""Simulation in a browser: the same bits as the native library, and what a user does to it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.browser import Page, opened_browser
from support.engine_page import engine_rows, open_engine

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.browser.modes import with_wrenches
from cardsflow_fmu.models.native_loop import NativeLoop

pytestmark = pytest.mark.browser
EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    with opened_browser(tmp_path_factory.mktemp("browser")) as page:
        yield page


def native_rows(experiment: Experiment, count: int) -> np.ndarray:
    """Return the first rows of a run in the native library."""
    run = experiment.run.copy_with(duration=count * experiment.run.step)
    with NativeLoop(replace(experiment, run=run)) as loop:
        return loop.run().rows[:count]


@pytest.mark.parametrize(
    "name", ["planar_2r", "roboy_left_arm", "hill_arm", "cable_robot", "no_joint_encoders"]
)
def test_two_seconds_in_a_browser_are_those_of_the_native_library(
    browser: Page, tmp_path: Path, name: str
) -> None:
    experiment = Experiment.load(EXAMPLES / name)
    count = min(2000, experiment.run.steps)
    open_engine(browser, experiment, tmp_path)
    np.testing.assert_array_equal(engine_rows(browser, count), native_rows(experiment, count))


def test_constant_pull_acts_as_a_wrench_in_the_native_library(
    browser: Page, tmp_path: Path
) -> None:
    experiment = Experiment.load(EXAMPLES / "planar_2r")
    link = experiment.robot.links[-1].name
    pulled = with_wrenches(experiment)
    wires = {f"plant.w.{link}.f{axis}": f for axis, f in zip("xyz", (4.0, 0.0, -3.0), strict=True)}
    pulled = replace(pulled, wiring=pulled.wiring | wires)
    expected = native_rows(pulled, 300)
    assert np.abs(expected - native_rows(experiment, 300)).max() > 1.0  # tensions resist
    open_engine(browser, experiment, tmp_path)
    browser.evaluate(
        f"engine.pull(engine.drawing.links.indexOf({link!r}), [0, 0, 0], {{ force: [4, 0, -3] }})"
    )
    np.testing.assert_array_equal(engine_rows(browser, 300), expected)
