"""Steps of many instances, compared with `mujoco.rollout`: `test_published_model_speed.py -s`.

Both use the same muscle law, one thread and a loop in C over instances and steps, interleaved in
one run. For models of MyoSuite, constraints in MuJoCo are disabled, and so are joint limits and
friction in the core. The arm starts from the same pose in both.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from mujoco import rollout
from support.interleaved import interleaved, record
from support.robots.robots import EXAMPLES

from addin_sdfusion.robot import Robot, read_robot
from addin_sdfusion.robot.formats.mjcf.write import write_mjcf
from sim_dart import Batch

STEP, STEPS, INSTANCES = 1e-3, 50, 16


def _ratio(name: str, robot: Robot, model: mujoco.MjModel, command: float) -> float:
    """Return the time of `mujoco.rollout` over that of a batch."""
    batch = Batch(robot, INSTANCES, STEPS * STEP, substeps=STEPS, threads=1)
    start, commands = batch.get_state(), np.full(batch.commands.shape, command)
    model.opt.timestep, data = STEP, mujoco.MjData(model)
    if model.nq == len(robot.coordinates):
        data.qpos[:] = [c.initial for c in robot.coordinates]
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    initial = np.zeros((INSTANCES, mujoco.mj_stateSize(model, full)))
    for row in initial:
        mujoco.mj_getState(model, data, row, full)
    controls = np.full((INSTANCES, STEPS, model.nu), command)

    def ours() -> None:
        batch.set_state(start)
        batch.step(commands)

    def theirs() -> None:
        rollout.rollout(model, data, initial, controls)

    times = interleaved({"ours": ours, "MuJoCo": theirs}, calls=1, rounds=20)
    ratio = times["MuJoCo"] / times["ours"]
    record(f"step of {name}", us=times["ours"] / STEPS / INSTANCES * 1e6, rollout_over_ours=ratio)
    return ratio


def _without_constraints(robot: Robot, model: mujoco.MjModel) -> Robot:
    """Disable constraints of the model, and return the robot without limits and friction."""
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    joints = tuple(
        replace(
            joint,
            coordinates=tuple(
                replace(c, lower=-math.inf, upper=math.inf, friction=0.0) for c in joint.coordinates
            ),
        )
        for joint in robot.joints
    )
    return replace(robot, joints=joints)


@pytest.mark.parametrize("name", ["myoelbow_2dof6muscles", "myofinger_v0", "myohand", "myoarm"])
def test_step_is_faster_than_that_of_mujoco(shared: Path, name: str) -> None:
    file = shared / f"models/mjcf/{name}.xml"
    model = mujoco.MjModel.from_xml_path(str(file))
    assert _ratio(name, _without_constraints(read_robot(file), model), model, 0.2) > 3.0


@pytest.mark.parametrize("has_limits", [True, False])
def test_arm_in_lanes_is_faster_than_in_mujoco(tmp_path: Path, has_limits: bool) -> None:
    robot = read_robot(EXAMPLES / "roboy_left_arm/robot")
    write_mjcf(robot, tmp_path)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "roboy_left_arm.xml"))
    name = "roboy_left_arm" if has_limits else "roboy_left_arm without limits"
    stepped = robot if has_limits else _without_constraints(robot, model)
    assert _ratio(name, stepped, model, 20.0) > 5.0
