"""`locked` in [robot.joints] and [robot.coordinates]: in all engines, in FMUs, in messages."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.robots import PLANAR_2R
from support.run_modes import RUN_MODES

from addin_sdfusion.robot import InputError
from cardsflow_fmu import Experiment, build
from cardsflow_fmu.experiment.writer import experiment_data
from cardsflow_fmu.simulation.run import simulate
from sim_dart import CoreDynamics

LOCKED = """
[robot]
path = {path!r}
[robot.{table}]
locked = {value}
[reference]
spline = "quintic"
points = [{{ time = 0.0, q = [0.0] }}, {{ time = 0.2, q = [0.01] }}]
[controller]
kp = 400.0
kd = 40.0
[run]
step = 0.001
"""


def locked(
    folder: Path, table: str = "joints.joint_2", value: object = 0.3, **settings: Any
) -> Experiment:
    file = folder / "experiment.toml"
    path = str(PLANAR_2R / "robot/planar_2r_bodies.xml")
    file.write_text(LOCKED.format(path=path, table=table, value=value))
    return Experiment.load(file, settings)


@pytest.mark.parametrize(
    ("through", "engine"),
    [("direct", "core"), ("direct", "dart"), ("fmu", "auto"), ("native", "auto")],
)
def test_locked_joint_does_not_move(through: str, engine: str, tmp_path: Path) -> None:
    result = simulate(locked(tmp_path, **{"plant.engine": engine}), **RUN_MODES[through])
    assert [name for name in result.names if name.startswith("q.")] == ["q.joint_1"]
    assert result.summary["infeasible_ticks"] == 0
    assert result.summary["tracking"]["max"] < 1e-4
    lengths = CoreDynamics(Experiment.load(PLANAR_2R).robot).muscle_lengths
    ends = [result[name][-1] for name in result.names if name.startswith("l.")]
    np.testing.assert_allclose(ends, lengths(np.array([result["q.joint_1"][-1], 0.3])), atol=1e-12)


@pytest.mark.slow
def test_lock_is_included_in_fmus(tmp_path: Path) -> None:
    experiment = locked(tmp_path)
    build(experiment, tmp_path)
    with zipfile.ZipFile(tmp_path / "plant.fmu") as fmu:
        text = fmu.read("modelDescription.xml").decode()
    assert "q.joint_1" in text
    assert "joint_2" not in text
    assert experiment_data(experiment)["robot"]["joints"] == {"joint_2": {"locked": 0.3}}


@pytest.mark.parametrize(
    ("table", "value", "kept"),
    [
        ("joints.joint_2", "true", 1),
        ("coordinates.joint_2", "-0.1", 1),
        ("joints.joint_2", "[0.1]", 1),
        ("joints.joint_2", "0", 1),
        ("joints.joint_2", "false", 2),
    ],
)
def test_all_forms_of_a_lock_are_accepted(
    table: str, value: str, kept: int, tmp_path: Path
) -> None:
    points = [{"time": t, "q": [0.0] * kept} for t in (0.0, 0.2)]
    one = {"reference": {"spline": "quintic", "points": points}}
    experiment = locked(tmp_path, table, value, **one)
    assert len(experiment.robot.coordinates) == kept


@pytest.mark.parametrize(
    ("table", "value", "message"),
    [
        ("joints.joint_2", '"yes"', r"robot\.joints\.joint_2\.locked"),
        ("joints.joint_2", "[0.1, 0.2]", r"robot\.joints\.joint_2\.locked"),
        ("joints.joint_2", "nan", r"robot\.joints\.joint_2\.locked"),
        ("joints.joint_9", "true", r"joint_9.*joint_1, joint_2"),
        ("links.link_2", "true", r"robot\.links\.link_2\.locked"),
        (
            "joints.joint_2",
            "true\nmotr = true",
            r"'motr'; did you mean 'motor'\? .*locked, motor, effort",
        ),
    ],
)
def test_invalid_lock_is_reported(table: str, value: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        locked(tmp_path, table, value)


def test_completely_locked_robot_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no movable joint"):
        locked(tmp_path, **{"robot.joints.joint_1.locked": True})


def test_trajectories_of_the_robot_file_omit_locked_coordinates(tmp_path: Path) -> None:
    """Trajectories in CASPR files contain all joints. The other joints have the same motion."""
    named = {"reference": {"trajectory": "simple_joint_motion"}}
    first = {**named, "robot.joints.joint_2.locked": False, "robot.joints.joint_1.locked": True}
    whole = locked(tmp_path, value="false", **named).reference.curve
    for left, settings in enumerate((named, first)):
        curve = locked(tmp_path, **settings).reference.curve
        assert [p.time for p in curve.points] == [p.time for p in whole.points]
        for point, full in zip(curve.points, whole.points, strict=True):
            assert (point.q, point.qd) == ((full.q[left],), tuple(full.qd[left : left + 1]))
