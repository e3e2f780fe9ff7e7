"""Steps of MyoSuite models, compared with MuJoCo: `test_published_model_speed.py -s`.

Both use the same muscle law and a loop in C. Constraints in MuJoCo are disabled, and so are joint
limits and friction in the core.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from support.interleaved import interleaved, record

from addin_sdfusion.robot import read_robot
from sim_dart import Plant

STEP, STEPS = 1e-3, 500


@pytest.mark.parametrize("name", ["myoelbow_2dof6muscles", "myofinger_v0", "myohand", "myoarm"])
def test_step_is_faster_than_that_of_mujoco(shared: Path, name: str) -> None:
    file = shared / f"models/mjcf/{name}.xml"
    robot = read_robot(file)
    joints = tuple(
        replace(
            joint,
            coordinates=tuple(
                replace(c, lower=-math.inf, upper=math.inf, friction=0.0) for c in joint.coordinates
            ),
        )
        for joint in robot.joints
    )
    free = replace(robot, joints=joints)
    plant = Plant(free, STEPS * STEP, engine="core", substeps=STEPS)
    start, commands = plant.get_state(), np.full(len(robot.muscles), 0.2)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model.opt.timestep, data = STEP, mujoco.MjData(model)

    def ours() -> None:
        plant.set_state(start)
        plant.step(commands)

    def theirs() -> None:
        mujoco.mj_resetData(model, data)
        data.ctrl[:] = 0.2
        mujoco.mj_step(model, data, nstep=STEPS)

    times = interleaved({"ours": ours, "MuJoCo": theirs}, calls=1, rounds=20)
    ratio = times["MuJoCo"] / times["ours"]
    record(f"step of {name}", us=times["ours"] / STEPS * 1e6, mujoco_over_ours=ratio)
    assert ratio > 2.0
