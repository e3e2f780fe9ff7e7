"""Simulation in a browser: the same bits as the native library, and what a user does to it."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.browser import Page
from support.engine_page import engine_values, open_client, open_engine
from support.policies import random_policy
from support.robots.bent_cables import with_bent_cables
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import read_robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.browser.modes import with_wrenches
from cardsflow_fmu.models.browser.pose import pose_experiment
from cardsflow_fmu.models.native_loop import native_loop
from sim_dart import MusclePaths

pytestmark = pytest.mark.browser


def native_values(experiment: Experiment, count: int) -> dict[str, float]:
    """Return the outputs after some steps in the native library."""
    run = experiment.run.copy_with(duration=count * experiment.run.step)
    recording = native_loop(replace(experiment, run=run)).run()
    assert len(recording.rows) == count + 1
    return dict(zip(recording.names[1:], recording.rows[count, 1:].tolist(), strict=True))


def values_of(values: dict[str, float], names: Iterable[str]) -> np.ndarray:
    return np.array([values[name] for name in names])


def largest_change(a: dict[str, float], b: dict[str, float]) -> float:
    return float(np.abs(values_of(a, a) - values_of(b, a)).max())


@pytest.mark.parametrize(
    "name",
    ["planar_2r", "policy", "roboy_left_arm", "hill_arm", "cable_robot", "no_joint_encoders"],
)
def test_two_seconds_in_a_browser_are_those_of_the_native_library(
    page: Page, tmp_path: Path, name: str
) -> None:
    if name == "policy":
        experiment = Experiment.load(EXAMPLES / "planar_2r", random_policy(tmp_path))
    else:
        experiment = Experiment.load(EXAMPLES / name)
    count = min(2000, experiment.run.steps)
    open_engine(page, experiment, tmp_path)
    for end, steps in ((count // 2, count // 2), (count, count - count // 2)):
        expected = native_values(experiment, end)
        found = values_of(engine_values(page, steps), expected)
        np.testing.assert_array_equal(found, list(expected.values()))


def test_cable_friction_in_a_browser_is_that_of_the_native_library(
    page: Page, tmp_path: Path
) -> None:
    experiment = Experiment.load(EXAMPLES / "planar_2r")
    robot, q = experiment.robot, experiment.start.q
    rough, smoother = (
        replace(experiment, robot=with_bent_cables(robot, mu, q)) for mu in (0.2, 0.1)
    )
    expected = native_values(rough, 500)
    assert largest_change(expected, native_values(smoother, 500)) > 0.1
    open_engine(page, rough, tmp_path)
    found = values_of(engine_values(page, 500), expected)
    np.testing.assert_allclose(found, list(expected.values()), rtol=0.0, atol=1e-12)


def test_constant_pull_acts_as_a_wrench_in_the_native_library(page: Page, tmp_path: Path) -> None:
    experiment = Experiment.load(EXAMPLES / "planar_2r")
    link = experiment.robot.links[-1].name
    pulled = with_wrenches(experiment)
    wires = {f"plant.w.{link}.f{axis}": f for axis, f in zip("xyz", (4.0, 0.0, -3.0), strict=True)}
    pulled = replace(pulled, wiring=pulled.wiring | wires)
    expected = native_values(pulled, 300)
    assert largest_change(expected, native_values(experiment, 300)) > 1.0  # tensions resist
    open_engine(page, experiment, tmp_path)
    page.evaluate(
        f"engine.pull(engine.drawing.links.indexOf({link!r}), [0, 0, 0], {{ force: [4, 0, -3] }})"
    )
    found = values_of(engine_values(page, 300), expected)
    np.testing.assert_array_equal(found, list(expected.values()))


CHANGES = {
    "planar_2r": {
        "plant.tension_scale.cable_1": 0.5,
        "plant.break_time.cable_2": 0.1,
        "plant.mass_scale.link_2": 1.3,
        "controller.kp.joint_1": 1500.0,
        "muscles.cable_2.f_max": 40.0,
        "robot.gravity": [0.5, 0.0, -5.0],
    },
    "hill_arm": {"plant.tension_scale.biceps": 0.9},
    "no_joint_encoders": {"plant.mass_scale.lower_arm_left": 1.05},
}


@pytest.mark.parametrize("name", CHANGES)
def test_live_changes_are_settings_of_the_experiment(page: Page, tmp_path: Path, name: str) -> None:
    experiment = Experiment.load(EXAMPLES / name)
    open_engine(page, experiment, tmp_path)
    for key, value in CHANGES[name].items():
        page.evaluate(f"engine.change({key!r}, {value!r})")
    page.evaluate("engine.reset()")
    expected = native_values(Experiment.load(EXAMPLES / name, CHANGES[name]), 200)
    assert largest_change(expected, native_values(experiment, 200)) > 1e-4
    found = values_of(engine_values(page, 200), expected)
    np.testing.assert_allclose(found, list(expected.values()), rtol=1e-9, atol=1e-12)


def test_going_back_repeats_the_same_steps(page: Page, tmp_path: Path) -> None:
    open_engine(page, Experiment.load(EXAMPLES / "hill_arm"), tmp_path)
    script = """(() => {
      engine.run(205);
      engine.pull(1, [0, 0, 0.1], { target: [0.2, 0, 0.3], stiffness: 40 });
      engine.run(55);
      engine.change("plant.tension_scale.biceps", 0);
      engine.run(111);
      const end = [...engine.frame().values], saved = engine.saved();
      engine.goTo(17);
      const early = engine.k;
      engine.goTo(371);
      const again = [...engine.frame().values];
      engine.goTo(100);
      engine.run(3);
      const last = engine.last;
      engine.load(saved);
      return [early, last, [end, again, [...engine.frame().values]].map(String)];
    })()"""
    early, last, (end, again, loaded) = page.evaluate(script)
    assert (early, last) == (17, 103)
    assert end == again == loaded


def test_targets_of_joints_and_of_the_hand_are_reached(page: Page, tmp_path: Path) -> None:
    open_engine(page, Experiment.load(EXAMPLES / "roboy_left_arm"), tmp_path)
    script = """["joints", "task"].map(mode => {
      engine.setMode(mode);
      const goal = engine.target.goal.map((x, i) => x + (i ? -0.03 : 0.04));
      engine.setTarget(goal);
      engine.run(3000);
      const now = engine.plant.group(mode === "joints" ? "q" : "tasks");
      return Math.max(...goal.map((x, i) => Math.abs(x - now[i])));
    })"""
    assert max(page.evaluate(script)) < 1e-6  # in rad and m


def test_pose_has_the_lengths_and_moment_arms_of_the_robot(page: Page, tmp_path: Path) -> None:
    robot = read_robot(EXAMPLES / "hill_arm/robot")
    q = np.linspace(0.3, 0.5, len(robot.coordinates))
    open_engine(page, pose_experiment(robot, (0 * q).tolist()), tmp_path, ("pose",))
    page.evaluate(f"engine.setPose({q.tolist()})")
    frame = page.evaluate("(f => [f.lengths, f.jacobian].map(x => [...x]))(engine.frame())")
    state = MusclePaths(robot).evaluate(q)
    np.testing.assert_array_equal(frame[0], state.lengths)
    np.testing.assert_array_equal(frame[1], state.jacobian.ravel())
    curve = page.evaluate("engine.analysis.momentArms(0, 0)")
    slope = np.gradient(curve["lengths"], curve["q"], edge_order=2)
    np.testing.assert_allclose(curve["arms"], -slope, atol=1e-4)
    run = "(() => { try { engine.run(1); } catch (error) { return error.message; } })()"
    assert "choose another drive mode" in page.evaluate(run)


def test_worker_plays_and_reports_failures(page: Page, tmp_path: Path) -> None:
    open_client(page, Experiment.load(EXAMPLES / "planar_2r"), tmp_path)
    assert page.evaluate("wrong") == ""
    assert page.evaluate("play.setup.modes") == [
        *("reference", "joints", "task", "muscles", "pose")
    ]
    page.evaluate("play.play()")
    page.wait_for("frames.length > 20 && play.frame.time > 0.1")
    page.evaluate("play.pause()")
    assert page.evaluate("play.setMode('task').then(() => play.frame.mode)") == "task"
    assert "cannot be changed" in page.evaluate(
        "play.set('run.step', 1).catch(error => error.message)"
    )
    page.evaluate("play.set('plant.mass_scale.link_2', 1e-9).then(() => play.setMode('muscles'))")
    assert page.evaluate("play.options()") == ["--set", "plant.mass_scale.link_2=1e-9"]
    failure = "play.setMuscles([NaN, 0, 0, 0]).then(() => play.run(3000)).catch(e => e.message)"
    assert "command nan of f.cable_1 is not finite" in page.evaluate(failure)
    assert not page.errors
