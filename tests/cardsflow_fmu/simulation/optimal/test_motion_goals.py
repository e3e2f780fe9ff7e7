"""Start, via times and holds of motions of a mass on a line, against least-norm solutions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES
from support.robots.slider import MASS, responses, slide

from addin_sdfusion.robot import read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.optimal.diagnosis import active_bounds
from cardsflow_fmu.simulation.optimal.files import write_motion_files
from cardsflow_fmu.simulation.optimal.optimise import NoMotionError
from cardsflow_fmu.simulation.optimal.tasks import TaskRates
from sim_dart.dynamics.core import CoreDynamics


def test_mass_passes_a_via_point_with_the_least_effort(tmp_path: Path) -> None:
    via = [{"fraction": 0.35, "q": 0.8}, {"q": 1.0}]
    motion, rows = slide(tmp_path, {"motion.goals": via}), responses(20, 0.8, [7, 20])[[0, 1, 3]]
    forces = np.linalg.lstsq(rows[:, :-1], np.array([0.8, 1.0, 0.0]), rcond=None)[0]
    np.testing.assert_allclose(motion.solution.iterate.u[:, 0], forces, atol=1e-3)
    timed = [{"time": 0.28, "q": 0.8}, {"q": 1.0}]
    assert slide(tmp_path, {"motion.goals": timed}).solution.cost == motion.solution.cost


def test_via_point_at_a_fraction_of_a_free_duration(tmp_path: Path) -> None:
    """The effort of the least-norm forces falls with T^3, so that the cost has one minimum."""
    via = [{"fraction": 0.5, "q": 0.9}, {"q": 1.0}]
    settings = {"motion.goals": via, "motion.duration": [0.2, 4.0], "motion.cost.time": 100.0}
    motion = slide(tmp_path, {**settings, "motion.cost.forces": 1.0})
    rows = responses(20, 1.0, [10, 20])[[0, 1, 3], :-1]
    forces = np.linalg.lstsq(rows, np.array([0.9, 1.0, 0.0]), rcond=None)[0]
    effort = forces @ forces / 20  # of a motion of 1 s; that of T s is effort / T^3
    assert motion.duration == pytest.approx((3.0 * effort / 100.0) ** 0.25, rel=1e-4)


def test_mass_rests_while_it_holds(tmp_path: Path) -> None:
    held = [{"time": 0.32, "hold": 0.16, "q": 0.5}, {"hold": 0.08, "q": 1.0}]
    x = slide(tmp_path, {"motion.goals": held}).solution.iterate.x
    np.testing.assert_allclose(x[8:13], np.tile([0.5, 0.0], (5, 1)), atol=1e-7)
    np.testing.assert_allclose(x[18:], np.tile([1.0, 0.0], (3, 1)), atol=1e-7)


def test_free_start_is_the_cheapest(tmp_path: Path) -> None:
    """A free velocity needs no force after the start; a free position starts at the goal."""
    goals = [{"time": 0.4, "q": 0.5}, {"q": 1.0, "rest": False}]
    motion = slide(tmp_path, {"motion.goals": goals, "motion.start.free_speeds": ["x"]})
    assert motion.solution.iterate.x[0] == pytest.approx([0.0, 1.25], abs=1e-6)
    assert motion.solution.cost == pytest.approx(0.0, abs=1e-6)
    still = slide(tmp_path, {"motion.start.free": ["*"]})
    assert still.solution.iterate.x[0] == pytest.approx([1.0, 0.0], abs=1e-6)


def test_run_starts_where_the_motion_starts(tmp_path: Path) -> None:
    own = {"motion.start.free": ["x"], "motion.start.free_speeds": ["x"]}
    motion = slide(tmp_path, {**own, "motion.goals": [{"q": 1.0, "rest": False}]})
    write_motion_files(motion, tmp_path / "motion.csv")
    settings = {**own, "reference.type": "optimised"}
    start = Experiment.load(tmp_path / "experiment.toml", settings).start
    assert (*start.q, *start.qd) == pytest.approx(motion.solution.iterate.x[0], abs=1e-9)


def test_periodic_motion_through_a_via_point_has_the_least_effort(tmp_path: Path) -> None:
    """The forces and the free velocity at the start satisfy three linear conditions."""
    via = {"motion.goals": [{"fraction": 0.35, "q": 0.8}], "motion.periodic": 1.0}
    at, rows = slide(tmp_path, via).solution.iterate, responses(20, 0.8, [7, 20])
    returns = rows[3] - np.eye(21)[20]
    A, b = np.vstack([rows[0], rows[1], returns]), np.array([0.8, 1.0, 0.0])
    weights = np.diag([*np.ones(20), 0.0])  # the velocity has no cost
    kkt = np.block([[weights, A.T], [A, np.zeros((3, 3))]])
    expected = np.linalg.solve(kkt, np.concatenate([np.zeros(21), b]))[:21]
    np.testing.assert_allclose([*at.u[:, 0], at.x[0, 1]], expected, atol=1e-3)
    assert at.x[-1] == pytest.approx(at.x[0] + [1.0, 0.0], abs=1e-7)


def test_forces_change_at_the_largest_rate(tmp_path: Path) -> None:
    """The force of the least time falls at the largest rate R: d = R T³ (1 - 1/N²) / (12 m)."""
    own = {"motion.duration": [0.1, 4.0], "motion.bounds.f_rate_max": 80.0}
    motion = slide(tmp_path, {**own, "motion.cost.time": 1.0})
    expected = (12.0 * MASS / 80.0 / (1.0 - 1.0 / 20**2)) ** (1 / 3)
    assert motion.duration == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"bounds.f_rate_max": 20.0},
            "q.x must be 1, but is 0.4256 at node 20 .* limits.*: rate of x",
        ),
        (
            {"goals": [{"fraction": 0.1, "q": 0.9}, {"q": 1.0}], "bounds.f_max": 100.0},
            r"q.x must be 0.9, but is .* at node 2 of 20 \(t = 0.08 s\)",
        ),
        (
            {"goals": [{"time": 0.4, "hold": 0.36, "q": 0.0}, {"q": 1.0}]},
            "q.x must be 1, but is .* at node 20 of 20",
        ),
        (
            {"periodic": 1.0, "bounds.q_max": 0.5},
            "q.x must be from -90 to 0.5, but is .* at node 20",
        ),
        ({"periodic": 1.0, "bounds.qd_max": 0.5}, "periodic.q.x is missed by 0.6 at node 20 of 20"),
    ],
)
def test_infeasible_motion_names_constraint_and_node(
    tmp_path: Path, settings: dict[str, Any], message: str
) -> None:
    own = {f"motion.{key}": value for key, value in settings.items()}
    if "motion.periodic" in own:
        own["motion.goals"] = []
    with pytest.raises(NoMotionError, match=f"^no motion found: {message}"):
        slide(tmp_path, own)


def test_mass_passes_with_a_velocity(tmp_path: Path) -> None:
    """A goal at the end with a velocity does not rest."""
    goals = [{"fraction": 0.35, "qd": 2.0}, {"q": 1.0, "qd": 0.5}]
    u = slide(tmp_path, {"motion.goals": goals}).solution.iterate.u[:, 0]
    rows = responses(20, 0.8, [7, 20])[[2, 1, 3], :-1]
    forces = np.linalg.lstsq(rows, np.array([2.0, 1.0, 0.5]), rcond=None)[0]
    np.testing.assert_allclose(u, forces, atol=1e-3)


def test_rates_of_task_coordinates_have_exact_derivatives() -> None:
    robot = read_robot(EXAMPLES / "roboy_left_arm" / "robot")
    rates = TaskRates(CoreDynamics(robot), np.arange(3), 8)
    x, step = np.array([[1.4, 0.2, 0.1, -1.0, 1.0, -2.0, 0.5, 3.0]]), 1e-5
    yd, J = rates(x)
    for k, row in enumerate(np.eye(8)):
        change = (rates(x + step * row)[0] - rates(x - step * row)[0]) / (2.0 * step)
        np.testing.assert_allclose(J[0, :, k], change[0], atol=1e-8)
    np.testing.assert_allclose(yd[0], J[0, :, 4:] @ x[0, 4:])


def test_active_bounds_of_the_least_time(tmp_path: Path) -> None:
    """The force is at a limit all the time, and drives and brakes for equally long."""
    own = {"motion.duration": [0.1, 2.0], "motion.cost.time": 1.0}
    motion = slide(tmp_path, {**own, "motion.bounds.f_max": 50.0, "motion.bounds.f_min": -50.0})
    assert motion.duration == pytest.approx(0.4, abs=1e-6)
    found = active_bounds(motion.problem, motion.solution)
    shares = {name: is_at.mean() for name, (_, is_at) in found.items()}
    assert shares == {"tau.x maximum": 0.5, "tau.x minimum": 0.5}
