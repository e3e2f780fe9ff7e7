"""The C core, compared with MuJoCo in one run: `pytest tests/benchmarks/test_native_speed.py -s`.

The benchmark first checks that both simulate the same steps of the same robots.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from support.interleaved import interleaved, record
from support.oracles.mujoco_model import MujocoRobot
from support.robots.robots import EXAMPLES, chain, planar_2r, with_coordinates

from addin_sdfusion.robot import Robot, read_robot
from sim_dart import compile_blob
from sim_dart.core.library import Core, library

STEP = 1e-3
LOOP_LIMIT, CALL_LIMIT, THREADS_LIMIT = 4.0, 2.0, 1.8


def two_links() -> Robot:
    """Return the arm with inertias of rods, since MuJoCo rejects the original inertias."""
    robot = planar_2r()
    rods = [
        replace(k, inertia=replace(k.inertia, ixx=0.01, iyy=0.01, izz=0.01)) for k in robot.links
    ]
    return replace(robot, links=tuple(rods))


def left_arm() -> Robot:
    """Return the left arm of the example."""
    return read_robot(EXAMPLES / "roboy_left_arm/robot")


ROBOTS: dict[str, Callable[[], Robot]] = {
    "two-link arm": two_links,
    "arm": left_arm,
    "20-joint chain, 60 muscles": chain,
}
every_robot = pytest.mark.parametrize("name", ROBOTS)


class CorePlant:
    """Plant of the C core."""

    def __init__(self, robot: Robot) -> None:
        self.core = Core(compile_blob(robot))
        n = len(robot.coordinates)
        self.q, self.qd = self.core.array("q", n), self.core.array("qd", n)

    def reset(self, q: np.ndarray) -> None:
        self.q[:], self.qd[:] = q, 0.0
        self.core.move(self.core.handle, self.q.tobytes())

    def run(self, forces: bytes, steps: int) -> None:
        assert not self.core.step(self.core.handle, forces, None, STEP, steps)


def both(name: str) -> tuple[CorePlant, MujocoRobot, np.ndarray, np.ndarray]:
    """Return the robot in both engines, its start pose, and muscle forces."""
    # The robot has no joint limits, since those of MuJoCo are softer.
    robot = with_coordinates(ROBOTS[name](), lower=-math.inf, upper=math.inf)
    start = np.full(len(robot.coordinates), 0.1)
    forces = np.array([muscle.f_min for muscle in robot.muscles])
    return CorePlant(robot), MujocoRobot(robot, step=STEP), start, forces


def ratio_of(
    name: str, ours: Callable[[], None], theirs: Callable[[], None], steps: int, *, calls: int
) -> float:
    """Return the time of MuJoCo relative to the core, and record both times per step."""
    times = interleaved({"core": ours, "mujoco": theirs}, calls=calls, rounds=80)
    ratio = times["mujoco"] / times["core"]
    each = {f"{engine}_us": seconds / steps * 1e6 for engine, seconds in times.items()}
    record(name, mujoco_ratio=ratio, **each)
    return ratio


@every_robot
def test_both_engines_simulate_the_same_steps(name: str) -> None:
    core, mujoco, start, forces = both(name)
    core.reset(start)
    mujoco.move(start)
    core.run(forces.tobytes(), 50)
    mujoco.run(forces, 50)
    np.testing.assert_allclose(core.q, mujoco.q, rtol=0, atol=1e-9)
    assert np.abs(core.q - start).max() > 1e-4


@every_robot
def test_speed_of_the_loop_in_c(name: str) -> None:
    core, mujoco, start, forces = both(name)
    packed, steps = forces.tobytes(), 200

    def ours() -> None:
        core.reset(start)
        core.run(packed, steps)

    def theirs() -> None:
        mujoco.move(start)
        mujoco.run(forces, steps)

    assert ratio_of(f"loop in C, {name}", ours, theirs, steps, calls=5) >= LOOP_LIMIT


@every_robot
def test_speed_of_one_call_per_step_from_python(name: str) -> None:
    import mujoco

    core, rival, start, forces = both(name)
    packed, step, handle = forces.tobytes(), core.core.step, core.core.handle
    mj_step, model, data, calls = mujoco.mj_step, rival.model, rival.data, 200

    def ours() -> None:
        core.reset(start)
        for _ in range(calls):
            step(handle, packed, None, STEP, 1)

    def theirs() -> None:
        rival.move(start)
        data.ctrl[:] = forces
        for _ in range(calls):
            mj_step(model, data)

    assert ratio_of(f"one call a step, {name}", ours, theirs, calls, calls=2) >= CALL_LIMIT


def test_speed_of_two_threads() -> None:
    """Run the chain in two threads, since calls release the Python lock (GIL)."""
    free = ctypes.CDLL(library()._name)
    free.core_step.argtypes = library().core_step.argtypes
    start = np.full(20, 0.1)
    plants = [CorePlant(chain()) for _ in range(2)]
    forces = np.array([muscle.f_min for muscle in chain().muscles]).tobytes()

    def run(plant: CorePlant) -> None:
        plant.reset(start)
        assert not free.core_step(plant.core.handle, forces, None, STEP, 2000)

    with ThreadPoolExecutor(2) as pool:
        times = interleaved(
            {
                "one": lambda: [run(plant) for plant in plants],
                "two": lambda: list(pool.map(run, plants)),
            },
            calls=1,
            rounds=40,
        )
    ratio = times["one"] / times["two"]
    record("two threads", ratio=ratio)
    assert ratio >= THREADS_LIMIT
