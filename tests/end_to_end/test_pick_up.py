"""The arm picks up a box with contact, friction and muscles, from files to results."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot.formats.read import read
from cardsflow_fmu import Experiment, Result, build, run
from cardsflow_fmu.results.summary_text import describe_summary
from cardsflow_fmu.simulation.run import simulate

PICK_UP = EXAMPLES / "pick_up"
WEIGHT = 0.2 * 9.81
ARMS = ("near", "far")


@cache
def picked_up(**settings: object) -> Result:
    changes = {key.replace("__", "."): value for key, value in settings.items()}
    return simulate(Experiment.load(PICK_UP, changes), coupling="direct")


def test_robot_has_no_findings() -> None:
    assert read(PICK_UP / "robot").findings == ()


@pytest.mark.slow
def test_box_is_lifted_with_the_hand() -> None:
    result = picked_up()
    assert result.summary["status"] == "complete"
    assert result.summary["infeasible_ticks"] == 0
    friction = result.summary["contact_friction"]
    assert friction == {"law": "pyramid", "excess": pytest.approx(np.sqrt(2.0) - 1.0)}
    assert any("41% too strong" in line for line in describe_summary(result.summary))
    assert result["object.box.z"][-1] - result["object.box.z"][0] == pytest.approx(0.2, abs=5e-3)
    hand = 1.0 + 0.4 * np.cos(np.pi + result["q.shoulder"])  # height of the elbow
    since = result["time"] > 1.7
    offset = (result["object.box.z"] - hand)[since]
    assert np.ptp(offset) < 1e-3  # it does not slip
    assert result["object.box.qw"][-1] > 0.9999  # it stays upright


@pytest.mark.slow
def test_friction_cones_that_do_not_converge_are_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim_dart.dart.world._SWEEPS", 1)
    result = picked_up(world__friction_law="cone", run__duration=0.05)
    friction = result.summary["contact_friction"]
    assert friction["not_converged_steps"] == np.count_nonzero(result["friction_not_converged"])
    assert 0 < friction["not_converged_steps"] <= friction["steps"] == len(result["time"])
    assert friction["error"] == result["friction_error"].max() > 1e-6
    said = f"contact forces of {friction['not_converged_steps']} of {friction['steps']} steps"
    assert any(said in warning for warning in result.summary["warnings"])
    assert any(said in line for line in describe_summary(result.summary))
    monkeypatch.undo()
    solved = picked_up(
        world__friction_law="cone", run__duration=0.04
    ).summary  # without a table of contact forces
    assert solved["contact_friction"]["not_converged_steps"] == 0
    assert not any("Coulomb" in warning for warning in solved["warnings"])


@pytest.mark.slow
def test_table_supports_the_box_until_it_is_lifted() -> None:
    result = picked_up()
    time, force = result["time"], result["contact.box.fz"]
    resting, held = (time > 0.2) & (time < 1.2), time > 3.5
    np.testing.assert_allclose(force[resting], WEIGHT, rtol=1e-3)
    np.testing.assert_allclose(force[held], WEIGHT, rtol=1e-3)
    fingers = result["contact.left_finger.fz"] + result["contact.right_finger.fz"]
    np.testing.assert_array_equal(fingers[resting], 0.0)
    np.testing.assert_allclose(fingers[held], -WEIGHT, rtol=1e-3)


@pytest.mark.slow
def test_finger_forces_match_their_gains() -> None:
    result = picked_up()
    held = result["time"] > 3.5
    for side, sign in (("left", 1.0), ("right", -1.0)):
        np.testing.assert_allclose(
            sign * result[f"contact.{side}_finger.fy"][held], 0.2 * 2500 * 0.01, rtol=5e-3
        )


@pytest.mark.slow
def test_motion_of_the_box_matches_the_contact_forces() -> None:
    """The contact forces minus the weight equal mass times acceleration."""
    result = picked_up()
    time, z = result["time"], result["object.box.z"]
    step = time[1] - time[0]
    acceleration = np.diff(z, 2) / step**2  # exact for the step of semi-implicit Euler
    lifted = (time[2:] > 1.8) & (time[2:] < 3.0)
    force = result["contact.box.fz"][2:] - WEIGHT
    np.testing.assert_allclose(force[lifted], 0.2 * acceleration[lifted], atol=2e-3)


@pytest.mark.slow
def test_box_is_not_lifted_with_low_friction() -> None:
    result = picked_up(world__friction=0.15)
    assert result["object.box.z"][-1] < 0.6


@pytest.mark.slow
def test_two_arms_lift_a_bar_together() -> None:
    """Both arms carry the weight. The bar remains horizontal at the height of the hands."""
    result = simulate(Experiment.load(EXAMPLES / "two_arms"), coupling="direct")
    assert result.summary["infeasible_ticks"] == 0
    held = result["time"] > 3.5
    fingers = [f"contact.{arm}_{side}_finger.fz" for arm in ARMS for side in ("left", "right")]
    np.testing.assert_allclose(sum(result[f][held] for f in fingers), -2.0 * WEIGHT, rtol=1e-3)
    assert result["object.bar.z"][-1] - result["object.bar.z"][0] == pytest.approx(0.2, abs=5e-3)
    assert result["object.bar.qw"][-1] > 0.9999
    for arm in ARMS:
        carried = sum(result[f][held] for f in fingers if arm in f)
        assert (carried < -0.5 * WEIGHT).all()


@pytest.mark.slow
def test_fmus_include_contacts_and_are_valid(tmp_path: Path) -> None:
    settings = {
        "run.duration": 0.3,
        "start.q": [-1.5708, 1.5708, -0.03, 0.03],
        "reference.points": [
            {"time": t, "q": [-1.5708 - 0.2 * t, 1.5708 + 0.2 * t, -0.04, 0.04]} for t in (0.0, 1.0)
        ],
    }
    experiment = Experiment.load(PICK_UP, settings)
    for fmi in ("2.0", "3.0"):
        result = simulate(experiment, fmi=fmi)  # type: ignore[arg-type]
        assert result["contact.left_finger.fy"].max() > 1.0
        for file in build(experiment, tmp_path / fmi, fmi=fmi).values():  # type: ignore[arg-type]
            assert validate_fmu(str(file)) == []


@pytest.mark.slow
def test_run_draws_paths_and_contacts(tmp_path: Path) -> None:
    run(
        Experiment.load(PICK_UP, {"run.duration": 0.05, "run.figures": True}),
        tmp_path,
        coupling="direct",
    )
    assert (tmp_path / "world.png").read_bytes().startswith(b"\x89PNG")
    drawn = (tmp_path / "world.svg").read_text()
    assert "contact.left_finger" in drawn
    assert "object.box.z" in drawn
    run(Experiment.load(PICK_UP, {"run.duration": 0.05}), tmp_path, coupling="direct")  # again
