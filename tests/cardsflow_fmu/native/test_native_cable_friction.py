"""Cable friction in runs, with compensation by a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.experiments import with_robot
from support.fmu.native_states import check_states_repeat
from support.robots.bent_cables import with_bent_cables
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import InputError, Robot, read_robot
from cardsflow_fmu import Experiment
from cardsflow_fmu.simulation.build import build
from cardsflow_fmu.simulation.run import simulate

ARM = EXAMPLES / "roboy_left_arm"
START = (1.45, 0.0, 0.0, -1.3)
WINCHES = {
    "muscles.*.model": {
        "kind": "winch",
        "drum_radius": 0.01,
        "gear_ratio": 20.0,
        "motor_inertia": 1e-6,
        "axial_stiffness": 5e4,
        "max_torque": 0.5,
        "rest_length": 0.3,
    }
}


def flower(
    folder: Path, friction: float, duration: float, first: float | None = None, **more: Any
) -> Experiment:
    """Return Roboy's arm on its flower, with a bend in every cable and undelayed state.

    `first` is the coefficient of the first muscle in its first bend.
    """
    robot = _with_friction(
        with_bent_cables(read_robot(ARM / "robot/model.sdf"), friction, START), first
    )
    return with_robot("roboy_left_arm", robot, folder, **{"run.duration": duration}, **more)


def _with_friction(robot: Robot, first: float | None) -> Robot:
    muscle, *others = robot.muscles
    begin, bend, *rest = muscle.via_points
    points = (begin, replace(bend, friction=first), *rest)
    return robot.with_muscles([replace(muscle, via_points=points), *others])


@pytest.mark.native
def test_tensions_vary_along_cables_and_friction_dissipates_energy(tmp_path: Path) -> None:
    settings = {"plant.energy": True, "plant.friction_scale": 1.2}
    experiment = flower(tmp_path, 0.2, 0.3, first=0.25, **settings)
    found = [muscle.bend_friction for muscle in experiment.plant_robot.muscles[:2]]
    assert found == [(1.2 * 0.25,), (1.2 * 0.2,)]
    native = simulate(experiment, coupling="direct")
    assert native.summary["engine"]["plant"] == "native"
    far, near = (
        native.rows[-1, [native.names.index(f"{name}.motor{k}") for k in range(11)]]
        for name in ("far_tension", "f")
    )
    assert 0.01 < np.abs(np.log(far / near)).max() < 0.24 * 2  # mu theta
    assert native.rows[-1, native.names.index("work.friction")] < 0


@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize("part", ["plant", "controller"])
def test_states_are_complete(part: str, tmp_path: Path) -> None:
    """A restored state continues as before."""
    file = build(flower(tmp_path, 0.2, 0.3, **WINCHES), tmp_path / "fmus", compute="c")[part]
    check_states_repeat(file, tmp_path / "unpacked", step=5e-3)


@pytest.mark.slow
@pytest.mark.native
@pytest.mark.parametrize(("friction", "max_error"), [(0.1, 0.3), (0.2, 0.5)])
@pytest.mark.parametrize("known", [0.7, 1.3])
def test_hand_tracks_the_flower(
    friction: float, max_error: float, known: float, tmp_path: Path
) -> None:
    """RMS error in [mm], with a coefficient known to 30 % and a disturbance observer."""
    settings = {"plant.friction_scale": 1.0 / known, "controller.observer": 100.0}
    experiment = flower(tmp_path, known * friction, 14.0, **settings)
    assert hand_error(experiment) < max_error


def hand_error(experiment: Experiment) -> float:
    """Return the RMS error of the hand on the flower, in [mm], after the approach."""
    result = simulate(experiment, coupling="direct")
    columns = [[result.names.index(f"{k}.hand.{axis}") for axis in "xyz"] for k in ("y", "y_d")]
    rows = result.rows[result.rows[:, result.names.index("time")] > 2.0]
    off = rows[:, columns[0]] - rows[:, columns[1]]
    return 1e3 * float(np.sqrt((off**2).sum(axis=1).mean()))


def test_runge_kutta_is_rejected(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"does not support cable friction \(of motor0, motor1"):
        flower(tmp_path, 0.1, 0.3, **{"plant.integrator": "rk4"})


def test_friction_of_the_robot_is_set_by_the_experiment() -> None:
    """By name or pattern, within its bounds; a warning reports friction without effect."""
    example, given = EXAMPLES / "roboy_left_arm", {"muscles.*.friction": 0.1}
    single = {"muscles.motor1.friction": 0.2, "muscles.motor1.presliding": 1e-3}
    muscles = Experiment.load(example, given | single).robot.muscles
    assert [m.friction for m in muscles[:3]] == [0.1, 0.2, 0.1]
    assert muscles[1].presliding == 1e-3
    with pytest.raises(InputError, match=r"muscles\.motor1\.friction: .*-0\.1"):
        Experiment.load(example, {"muscles.motor1.friction": -0.1})
    straight = Experiment.load(EXAMPLES / "planar_2r", given)
    assert any("no cable with friction is bent" in line for line in straight.warnings())
    scaled = Experiment.load(example, {"plant.friction_scale": 2.0})
    assert any("no muscle has friction" in line for line in scaled.warnings())
