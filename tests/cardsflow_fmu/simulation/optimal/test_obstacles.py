"""Obstacles of motions: distances, shortest paths, and passages between nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import CommandLine
from support.robots.robots import EXAMPLES, PLANAR_2R

from cardsflow_fmu.experiment.motion.bounds import ObstacleSettings
from cardsflow_fmu.simulation.optimal.obstacles import obstacle_constraints
from cardsflow_fmu.simulation.optimal.optimise import NoMotionError, load_for_motion, optimise
from cardsflow_fmu.simulation.optimal.segments import nearest_parameters
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

HAND = """<cardsflow><endEffector name="tip" link="hand">0 0 0</endEffector></cardsflow>"""

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


def gantry_file(folder: Path) -> Path:
    (folder / "model.sdf").write_text(GANTRY)
    (folder / "cardsflow.xml").write_text(HAND)
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


def test_shortest_path_around_a_circle_has_tangents_and_an_arc(tmp_path: Path) -> None:
    """The least int v² dt is L² / T, with L = 2 sqrt(1 - r²) + r (pi - 2 acos r)."""
    r = 0.5
    own = {"motion.intervals": 60}
    own |= {"motion.obstacles": [{"centre": [0.0, 0.0, 0.0], "radius": 0.4, "clearance": 0.1}]}
    motion = optimise(load_for_motion(gantry_file(tmp_path), own))
    length = 2.0 * np.sqrt(1.0 - r * r) + r * (np.pi - 2.0 * np.arccos(r))
    assert motion.solution.cost == pytest.approx(length**2, rel=5e-3)
    nodes = motion.solution.iterate.x[:, :2]
    assert np.linalg.norm(nodes, axis=1).min() == pytest.approx(r, abs=1e-6)


def test_passage_between_nodes_is_the_first_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "obstacles=[{centre=[0.0,0.005,0.0],radius=0.05}]"
    own = ["--set", f"motion.{text}", "--set", "motion.intervals=5"]
    code, out, _ = CommandLine(capsys)("optimise", gantry_file(tmp_path), "-q", *own)
    assert code == 1
    first = out.splitlines()[0]
    assert first.startswith("warning     the motion violates obstacles[0].tip by up to 0.0")
    assert "between nodes, at t = 0.5" in first


@pytest.mark.parametrize("part", ["links", "cables"])
def test_links_and_cables_keep_their_distance(part: str) -> None:
    own = {"motion": {"duration": 0.7, "intervals": 20, "goals": [{"q": [0.6, -0.4]}]}}
    own |= {"start.q": [-0.5, 0.5]}
    free = optimise(load_for_motion(PLANAR_2R, own))
    settings = {"centre": [-0.35, -1.0, 1.95], "end": [-0.35, 1.0, 1.95], "radius": 0.05}
    if part == "cables":
        settings = {"centre": [0.1, -1.0, 1.84], "end": [0.1, 1.0, 1.84], "radius": 0.05}
    obstacle = {**settings, part: ["*"]}
    around = optimise(load_for_motion(PLANAR_2R, {**own, "motion.obstacles": [obstacle]}))
    (constraint,) = around.problem.problem.constraints
    distances = [constraint.evaluate(k.solution.iterate.x)[0].min() for k in (free, around)]
    assert distances[0] < 0.049
    assert distances[1] == pytest.approx(0.05, abs=1e-6)
    assert around.solution.cost > free.solution.cost


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
