"""Obstacles of motions: distances, shortest paths, and folded arms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu.experiment.motion.bounds import ObstacleSettings
from cardsflow_fmu.simulation.optimal.obstacles.constraints import obstacle_constraints
from cardsflow_fmu.simulation.optimal.obstacles.segments import nearest_parameters
from cardsflow_fmu.simulation.optimal.optimise import NoMotionError, load_for_motion, optimise
from cardsflow_fmu.simulation.optimal.problem import motion_problem
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.problem import Iterate
from controllers.optimal.transcription import Transcription
from sim_dart.dart.interference import segment_distances
from sim_dart.dynamics.core import CoreDynamics

INERTIA = "<inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia>"
GANTRY = f"""<sdf version="1.7"><model name="gantry">
<link name="base"/><link name="bridge"><inertial><mass>0.1</mass>{INERTIA}</inertial></link>
<link name="hand"><inertial><mass>1.0</mass>{INERTIA}</inertial></link>
<joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="x" type="prismatic"><parent>base</parent><child>bridge</child>
<axis><xyz>1 0 0</xyz></axis></joint>
<joint name="y" type="prismatic"><parent>bridge</parent><child>hand</child>
<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""

TOML = """
robot.path = "model.sdf"
robot.joints = { x = { motor = true, effort = 500.0 }, y = { motor = true, effort = 500.0 } }
start.q = [-1.0, 0.01]
controller = { kp = 100.0, kd = 20.0 }

[motion]
duration = 1.0
goals = [{ q = [1.0, 0.0], rest = false }]
start = { free_speeds = ["*"] }
cost = { speeds = 1.0 }
bounds = { q_min = -2.0, q_max = 2.0 }
"""


TIP = '<endEffector name="tip" link="hand">0 0 0</endEffector>'
STAY = """<myoMuscle name="stay" f_min="0" f_max="1"><link name="world">
<viaPoint type="FIXPOINT">0 2 0</viaPoint></link><link name="hand">
<viaPoint type="FIXPOINT">0 0 0</viaPoint></link></myoMuscle>"""

ARM = f"""<sdf version="1.7"><model name="arm">
<link name="base"/>
<link name="upper"><pose>0.5 0 0 0 0 0</pose><inertial><mass>1.0</mass>{INERTIA}</inertial></link>
<link name="lower"><pose>1.5 0 0 0 0 0</pose><inertial><mass>1.0</mass>{INERTIA}</inertial></link>
<joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="shoulder" type="revolute"><pose>-0.5 0 0 0 0 0</pose><parent>base</parent>
<child>upper</child><axis><xyz>0 0 1</xyz></axis></joint>
<joint name="elbow" type="revolute"><pose>-0.5 0 0 0 0 0</pose><parent>upper</parent>
<child>lower</child><axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"""

ARM_TIP = TIP.replace('"hand">0', '"lower">0.5')

ARM_TOML = """
robot.path = "model.sdf"
robot.joints.shoulder = { motor = true, effort = 90.0 }
robot.joints.elbow = { motor = true, effort = 90.0 }
start.q = [-0.6, 0.1]
controller = { kp = 100.0, kd = 20.0 }

[motion]
duration = 1.5
intervals = 30
goals = [{ q = [0.6, -0.1] }]
obstacles = [{ centre = [1.5, 0.0, 0.0], radius = 0.2, links = ["*"] }]
"""


def gantry_file(folder: Path) -> Path:
    (folder / "model.sdf").write_text(GANTRY)
    (folder / "cardsflow.xml").write_text(f"<cardsflow>{STAY}{TIP}</cardsflow>")
    (folder / "experiment.toml").write_text(TOML)
    return folder / "experiment.toml"


def test_nearest_points_of_segments_have_the_smallest_distance() -> None:
    rng = np.random.default_rng(2)
    a, b, c, d = rng.normal(size=(4, 300, 3))
    b[:20], d[10:40] = a[:20], c[10:40]  # points
    b[40:60] = a[40:60] + 2.0 * (d[40:60] - c[40:60])  # parallel
    s, t = nearest_parameters(a, b, c, d)
    found = np.linalg.norm(a + s * (b - a) - c - t * (d - c), axis=1)
    np.testing.assert_allclose(found, segment_distances(a, b, c, d), atol=1e-9)


@pytest.mark.parametrize("end", [{}, {"end": (0.5, 0.4, 0.9)}])
@pytest.mark.parametrize("example", ["planar_2r", "roboy_left_arm"])
def test_derivatives_of_distances_match_differences(example: str, end: Any) -> None:
    experiment = load_for_motion(
        EXAMPLES / example, {"motion": {"duration": 1.0, "goals": [{"q": 0.0}]}}
    )
    own = ObstacleSettings(centre=(0.4, 0.6, 0.8), radius=1e-3, links=["*"], cables=["*"], **end)
    dynamics = CoreDynamics(experiment.robot)
    assert experiment.motion is not None
    motion = experiment.motion.copy_with(obstacles=(own,))
    (constraint,), _ = obstacle_constraints(experiment, motion, dynamics, np.arange(1, 9), 9)
    x, e = 0.3 * np.random.default_rng(3).normal(size=(5, 9)), 1e-6
    x[:, : dynamics.n] += experiment.start.q
    J = constraint.evaluate(x)[1]
    for k in range(9):
        step = e * np.eye(9)[k]
        change = constraint.evaluate(x + step)[0] - constraint.evaluate(x - step)[0]
        np.testing.assert_allclose(J[:, :, k], change / (2.0 * e), atol=1e-7)


def test_derivatives_inside_intervals_match_differences() -> None:
    """By states and forces at the node before, and by the duration."""
    own = {"duration": [0.5, 0.9], "intervals": 4, "goals": [{"q": 0.0}]}
    own["obstacles"] = [{"centre": [0.4, 0.6, 0.8], "radius": 1e-3, "links": ["*"]}]
    found = motion_problem(load_for_motion(PLANAR_2R, {"motion": own}))
    (path,) = found.problem.constraints
    nodes, shares = np.array([0, 2, 3]), np.array([0.3, 0.5, 0.9])
    inside = replace(path, nodes=nodes, shares=shares)
    transcription = Transcription(replace(found.problem, constraints=[inside]))
    rng, e = np.random.default_rng(4), 1e-6
    at = found.guess._replace(x=found.guess.x + 0.1 * rng.normal(size=found.guess.x.shape))
    dx, du = rng.normal(size=at.x.shape), rng.normal(size=at.u.shape)

    def values(step: float) -> FloatArray:
        moved = Iterate(at.x + step * dx, at.u + step * du, at.duration + step)
        own = transcription.linearise(moved)
        assert own is not None
        return own.values[0]

    own_terms = transcription.linearise(at)
    assert own_terms is not None
    along = np.concatenate([dx[nodes], du[nodes], np.ones((3, 1))], axis=1)
    slope = np.einsum("kri,ki->kr", own_terms.jacobians[0], along)
    np.testing.assert_allclose(slope, (values(e) - values(-e)) / (2.0 * e), atol=1e-8)


@pytest.mark.parametrize(
    ("height", "radius", "intervals", "accuracy"),
    [(0.0, 0.5, 60, 5e-4), (0.0, 0.05, 5, 1e-2), (0.5, 0.2, 20, 1e-2), (1.0, 0.2, 30, 1e-2)],
)
def test_shortest_path_has_tangents_and_an_arc(
    height: float, radius: float, intervals: int, accuracy: float, tmp_path: Path
) -> None:
    """The least ∫ v² dt is L² / T, with the length L around an end of a wall.

    The straight path meets the axis, where the distance has no gradient. With 5 intervals, the hand
    moves by 8 radii in each. The last obstacle is a sphere, and the cable from above is the wall.
    """
    own = {"centre": [0.0, height, 0.0], "radius": 0.8 * radius, "clearance": 0.2 * radius}
    own |= {"cables": ["*"]} if height == 1.0 else {"end": [0.0, -height, 0.0]}
    settings = {"start.q": [-1.0, 0.0], "motion.intervals": intervals, "motion.obstacles": [own]}
    motion = optimise(load_for_motion(gantry_file(tmp_path), settings))
    d = np.hypot(1.0, height)
    arc = 2.0 * radius * (np.arccos(-height / d) - np.arccos(radius / d))
    length = 2.0 * np.sqrt(d**2 - radius**2) + arc
    assert motion.solution.cost == pytest.approx(length**2, rel=accuracy)
    assert not motion.warnings
    x, y = motion.columns["q.x"], motion.columns["q.y"]
    if height == 1.0:  # the cable ends at [0, 2]
        s = np.clip((2.0 - y) / (x**2 + (y - 2.0) ** 2), 0.0, 1.0)
        distances = np.hypot(s * x, 1.0 - s * (2.0 - y))
    else:
        distances = np.hypot(x, np.maximum(abs(y) - height, 0.0))
    assert distances.min() == pytest.approx(radius, abs=2e-6)


def test_arm_folds_to_pass_a_sphere(tmp_path: Path) -> None:
    """Both links keep their distance from a sphere that is always in front of the stretched arm."""
    (tmp_path / "model.sdf").write_text(ARM)
    (tmp_path / "cardsflow.xml").write_text(f"<cardsflow>{ARM_TIP}</cardsflow>")
    (tmp_path / "experiment.toml").write_text(ARM_TOML)
    motion = optimise(load_for_motion(tmp_path / "experiment.toml"))
    assert motion.solution.status == "optimal"
    assert not motion.warnings
    a, b = motion.columns["q.shoulder"], motion.columns["q.elbow"]
    elbow = np.stack([np.cos(a), np.sin(a)], axis=-1)
    tip = elbow + np.stack([np.cos(a + b), np.sin(a + b)], axis=-1)
    s = np.linspace(0.0, 1.0, 401)[:, None, None]
    points = np.concatenate([s * elbow, elbow + s * (tip - elbow)])
    least = np.linalg.norm(points - [1.5, 0.0], axis=-1).min()
    assert least > 0.2 - 1e-6


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"goals": [{"y": {"tip.x": 5.0}}]}, "goals[0].y.tip.x is missed by 3 at node 9 of 9"),
        ({"bounds.y_max": {"tip.x": 0.5}}, "q.x must be 1, but is 0.5 at node 9 of 9"),
        ({"start.y": {"tip.x": -5.0}}, "start.y.tip.x is missed by 3 at node 0 of 9"),
        (
            {"obstacles": [{"centre": [1.0, 0.0, 0.0], "radius": 0.4}]},
            "q.x must be 1, but is 0.6 at node 9 of 9",
        ),
    ],
)
def test_infeasible_task_names_constraint_and_node(
    tmp_path: Path, settings: dict[str, Any], message: str
) -> None:
    own = {"motion.intervals": 9} | {f"motion.{key}": value for key, value in settings.items()}
    with pytest.raises(NoMotionError) as raised:
        optimise(load_for_motion(gantry_file(tmp_path), own))
    assert str(raised.value).startswith(f"no motion found: {message}")
