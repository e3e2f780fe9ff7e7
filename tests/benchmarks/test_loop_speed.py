"""Steps of mechanisms with closed loops, compared with MuJoCo.

Both simulate the same mechanisms. The benchmark first checks that the steps agree up to the
softness of the constraints in MuJoCo. Run `pytest tests/benchmarks/test_loop_speed.py -s`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.oracles.mujoco_model import MujocoRobot
from support.robots.loops import five_bar, four_bar, slider_crank

from addin_sdfusion.robot import Robot
from sim_dart import compile_blob
from sim_dart.core.library import Core

STEP = 1e-3
LIMIT = 2.0
"""Minimum ratio of the time of MuJoCo to the time of the core."""

ROBOTS: dict[str, Callable[[], Robot]] = {
    "four-bar linkage": four_bar,
    "slider-crank": slider_crank,
    "five-bar linkage": five_bar,
}


@pytest.mark.parametrize("name", ROBOTS)
def test_step_with_closed_loops(name: str) -> None:
    robot = ROBOTS[name]()
    n, steps = len(robot.coordinates), 200
    start = np.array([c.initial for c in robot.coordinates])
    forces = np.full(len(robot.muscles), 15.0)
    core, mujoco = Core(compile_blob(robot)), MujocoRobot(robot, step=STEP)
    q, qd = core.array("q", n), core.array("qd", n)
    packed = forces.tobytes()

    def ours() -> None:
        q[:], qd[:] = start, 0.0
        core.move(core.handle, q.tobytes())
        assert not core.step(core.handle, packed, None, STEP, steps)

    def theirs() -> None:
        mujoco.move(start)
        mujoco.run(forces, steps)

    ours()
    theirs()
    assert np.abs(q - start).max() > 0.1
    np.testing.assert_allclose(mujoco.q, q, rtol=0, atol=5e-3)

    times = interleaved({"core": ours, "mujoco": theirs}, calls=5, rounds=80)
    ratio = times["mujoco"] / times["core"]
    each = {f"{engine}_us": seconds / steps * 1e6 for engine, seconds in times.items()}
    record(f"step with loops, {name}", mujoco_ratio=ratio, **each)
    assert ratio >= LIMIT
