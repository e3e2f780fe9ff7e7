"""A design with a closed loop, exported to all formats that have loops, moves as in the core."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import designs
from support.designs.exported import snapshot_of
from support.oracles.closed_loops import closed, closed_poses

from addin_sdfusion.building.build_robot import build_robot
from addin_sdfusion.exporting.export import export_robot
from addin_sdfusion.robot import Robot, read_robot
from sim_dart import CoreDynamics

FILES = {
    "sdf": "model.sdf",
    "mjcf": "mjcf/four bars.xml",
    "osim": "four_bars.osim",
    "urdf": "urdf/four bars.urdf",
}
BY = 0.4
"""Motion of joint `a` in [rad]."""


@pytest.fixture
def exported(fusion: Any, tmp_path: Path) -> tuple[Robot, Path]:
    """Return the robot of the four-bar linkage, and the folder of its export."""
    settings = {"urdf": True, "mjcf": True, "visual": False, "collision": "none"}
    snapshot = snapshot_of(designs.closed_loop(), **settings)
    export_robot(snapshot, tmp_path)
    robot = build_robot(snapshot).robot
    assert robot is not None
    return robot, tmp_path


def test_every_format_has_the_loop_of_the_core(exported: tuple[Robot, Path]) -> None:
    """Link poses after a motion, and accelerations under gravity, agree with the built robot."""
    robot, folder = exported
    (loop,) = robot.loops
    poses = closed_poses(robot, "a", BY)
    for name, file in FILES.items():
        other = read_robot(folder / file)
        (same,) = other.loops
        assert (same.name, same.type, same.parent, same.child) == (
            loop.name, loop.type, loop.parent, loop.child,
        ), name  # fmt: skip
        theirs = closed_poses(other, "a", BY)
        for link, T in poses.items():
            assert theirs[link] == pytest.approx(T, abs=1e-12), (name, link)
        assert acceleration(other) == pytest.approx(acceleration(robot), rel=1e-10), name


def acceleration(robot: Robot) -> float:
    """Return the acceleration of joint `a` that the core computes at the moved pose."""
    q = closed(robot, "a", BY)
    qdd = CoreDynamics(robot).acceleration(q, np.zeros_like(q), np.zeros_like(q))
    return float(qdd[[c.name for c in robot.coordinates].index("a")])


@pytest.mark.interop
def test_the_loop_closes_in_mujoco(exported: tuple[Robot, Path]) -> None:
    """Its equalities are zero at the moved pose, where it accelerates like the core."""
    mujoco = pytest.importorskip("mujoco")
    robot, folder = exported
    model = mujoco.MjModel.from_xml_path(str(folder / FILES["mjcf"]))
    data = mujoco.MjData(model)
    for c, value in zip(robot.coordinates, closed(robot, "a", BY), strict=True):
        data.joint(c.name).qpos = value
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos).max() < 1e-12
    assert len(data.efc_pos) == 6
    assert data.joint("a").qacc[0] == pytest.approx(acceleration(robot), rel=1e-3)
    for _ in range(300):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    assert abs(data.joint("a").qpos[0] - BY) > 0.05
    assert np.abs(data.efc_pos).max() < 1e-4


@pytest.mark.interop
def test_the_loop_closes_in_opensim(exported: tuple[Robot, Path]) -> None:
    """Its constraints are zero at the moved pose, where it accelerates like the core."""
    opensim = pytest.importorskip("support.oracles.opensim_model").opensim
    robot, folder = exported
    model = opensim.Model(str(folder / FILES["osim"]))
    state = model.initSystem()
    coordinates = model.getCoordinateSet()
    for c, value in zip(robot.coordinates, closed(robot, "a", BY), strict=True):
        coordinates.get(c.name).setValue(state, value, False)
    model.realizeAcceleration(state)
    gaps = [state.getQErr().get(k) for k in range(state.getNQErr())]
    assert max(map(abs, gaps)) < 1e-12
    found = coordinates.get("a").getAccelerationValue(state)
    assert found == pytest.approx(acceleration(robot), rel=1e-8)
    manager = opensim.Manager(model)
    state.setTime(0.0)
    manager.initialize(state)
    after = manager.integrate(0.2)
    model.realizePosition(after)
    gaps = [after.getQErr().get(k) for k in range(after.getNQErr())]
    assert max(map(abs, gaps)) < 1e-4
    assert abs(coordinates.get("a").getValue(after) - BY) > 0.05
