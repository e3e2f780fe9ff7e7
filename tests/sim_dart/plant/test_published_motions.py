"""Muscles and motions of published models compared with OpenSim 4.6 and MuJoCo 4.0."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.robots.muscle_bench import state_rates

from addin_sdfusion.robot import Robot, read_robot
from sim_dart import MusclePaths, Plant
from sim_dart.core.arrays import FloatArray
from sim_dart.core.blob import compile_blob
from sim_dart.core.library import Core
from sim_dart.muscles.laws import MuscleLaws

OPENSIM = ("arm26", "leg6dof9musc", "gait10dof18musc", "gait2392_thelen2003muscle",
           "subject_walk_scaled")  # fmt: skip
ROW = 0.05
"""Time between two rows of a motion, in [s]."""
OWN = {"activation": "activation", "fibre_length": "fiber_length"}
"""Name in OpenSim of each state of a muscle."""


def opensim(shared: Path, name: str) -> tuple[Robot, Any]:
    robot = read_robot(shared / f"models/opensim/{name}.osim")
    return robot, json.loads((shared / f"reference/opensim/{name}.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("name", OPENSIM)
def test_moment_arms_forces_and_fibre_speeds(shared: Path, name: str) -> None:
    """Compare muscles without wraps to 1e-12 m, 1e-11 F0, and 1e-7 of the velocity."""
    robot, content = opensim(shared, name)
    paths, core = MusclePaths(robot), Core(compile_blob(robot))
    laws = MuscleLaws(robot, core)
    names = [c["name"] for c in content["coordinates"]]
    own = [c.name for c in robot.coordinates]
    index = {m["name"]: i for i, m in enumerate(content["muscles"])}
    state = {name: k for k, name in enumerate(laws.state_names)}
    compared = 0
    for pose in content["poses"]:
        q = np.array([pose["q"][names.index(c)] for c in own])
        qd = np.array([pose["u"][names.index(c)] for c in own])
        L = paths.evaluate(q).jacobian
        core.move(core.handle, q.tobytes())
        commands = np.array([pose["activation"][index[m.name]] for m in robot.muscles])
        for muscle, activation in zip(robot.muscles, commands, strict=True):
            laws.states[state[f"activation.{muscle.name}"]] = activation
            fibre = pose["off_equilibrium"][index[muscle.name]]["fiber_length"]
            laws.states[state[f"fibre_length.{muscle.name}"]] = fibre
        tensions = laws.drive(qd, commands)
        rates = state_rates(core, commands)
        for k, muscle in enumerate(robot.muscles):
            numbers = pose["off_equilibrium"][index[muscle.name]]
            if muscle.wraps or not numbers["fiber_length"]:  # OpenSim did not find an equilibrium
                continue
            arms = _coupled_jacobian(pose["dl_dq"][index[muscle.name]], own, pose)
            np.testing.assert_allclose(L[k], arms, atol=1e-12)
            F0 = content["muscles"][index[muscle.name]]["max_isometric_force"]
            assert tensions[k] == pytest.approx(numbers["tendon_force"], abs=1e-11 * F0)
            rate = rates[state[f"fibre_length.{muscle.name}"]]
            assert rate == pytest.approx(numbers["fiber_velocity"], rel=1e-7, abs=1e-10)
            compared += 1
    assert compared > 10


def _coupled_jacobian(arms: dict[str, float], own: list[str], pose: Any) -> FloatArray:
    """Return dl/dq including couplings."""
    found = np.zeros(len(own))
    for name, arm in arms.items():
        slopes = pose.get("gamma_dep", {}).get(name, {name: 1.0})
        for independent, slope in slopes.items():
            if independent in own:
                found[own.index(independent)] += slope * arm
    return found


def without_stops(robot: Robot) -> Robot:
    """Return the robot without limits and friction, which these motions do not include."""
    words: dict[str, Any] = {"lower": -math.inf, "upper": math.inf, "friction": 0.0}
    return replace(
        robot,
        joints=tuple(
            replace(j, coordinates=tuple(replace(c, **words) for c in j.coordinates))
            for j in robot.joints
        ),
    )


def largest_differences(
    plant: Plant, rows: FloatArray, columns: tuple[list[int], list[int], list[int]],
    commands: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return the largest differences of positions and velocities over all rows."""
    at, rates, states = columns
    plant.reset(rows[0, at], rows[0, rates])
    start = plant.get_state()
    start[len(start) - len(states) :] = rows[0, states]
    plant.set_state(start)
    off, steps = np.zeros(2), round(ROW / plant.step_size)
    for row in rows[1:]:
        for _ in range(steps):
            plant.step(commands)
        off = np.maximum(off, [abs(plant.q - row[at]).max(), abs(plant.qd - row[rates]).max()])
    return float(off[0]), float(off[1])


@pytest.mark.slow
def test_gait10dof_falls_like_in_opensim(shared: Path) -> None:
    """Compare 1 s with 18 excited muscles; OpenSim's errors are 1e-8 rad and 1e-6 rad/s."""
    robot, _ = opensim(shared, "gait10dof18musc")
    run = json.loads((shared / "reference/opensim/gait10dof18musc_forward.json").read_text())
    plant = Plant(without_stops(robot), 6.25e-5, integrator="rk4")  # elastic tendons: order three

    def column(end: str) -> int:
        return next(k for k, name in enumerate(run["columns"]) if name.endswith(end))

    states = [name.split(".", 1) for name in plant.muscle_state_names]
    columns = (
        [column(f"/{c.name}/value") for c in robot.coordinates],
        [column(f"/{c.name}/speed") for c in robot.coordinates],
        [column(f"/{muscle}/{OWN[state]}") for state, muscle in states],
    )
    commands = np.array([run["excitation"][muscle.name] for muscle in robot.muscles])
    q, qd = largest_differences(plant, np.array(run["rows"]), columns, commands)
    assert q < 1e-8
    assert qd < 1e-6


@pytest.mark.slow
def test_myosuite_elbow_moves_like_in_mujoco(shared: Path) -> None:
    """Compare 1 s without soft constraints of MuJoCo."""
    robot = read_robot(shared / "models/mjcf/myoelbow_2dof6muscles.xml")
    folder = shared / "reference/mjcf"
    content = json.loads((folder / "myoelbow_2dof6muscles.json").read_text())
    run = json.loads((folder / "myoelbow_2dof6muscles_forward.json").read_text())
    joints = content["dofs"]
    muscles = [actuator["name"] for actuator in content["actuators"]]
    n, m = len(joints), len(muscles)
    at = [1 + joints.index(c.name) for c in robot.coordinates]
    states = [1 + 2 * n + muscles.index(muscle.name) for muscle in robot.muscles]
    commands = np.array([run["ctrl"][muscles.index(muscle.name)] for muscle in robot.muscles])
    plant = Plant(without_stops(robot), 5e-5, integrator="rk4")
    assert len(plant.muscle_state_names) == m
    rows = np.array(run["tree_rk4"]["rows"])[:, : 1 + 2 * n + m]
    q, qd = largest_differences(plant, rows, (at, [k + n for k in at], states), commands)
    assert q < 1e-9
    assert qd < 1e-8
