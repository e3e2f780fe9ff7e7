"""Forward simulation of a full-body model, compared with OpenSim: `test_opensim_speed.py -s`.

Both start in the equilibrium of OpenSim, with minimum excitation. The error of each integrator is
relative to the same integrator with a finer step, since muscle paths over two cylinders differ.
"""

from __future__ import annotations

import math
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.interleaved import record

from addin_sdfusion.robot import Robot, read_robot
from sim_dart import Plant
from sim_dart.core.arrays import FloatArray

with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)  # raised by its SWIG wrapper
    opensim: Any = pytest.importorskip("opensim", reason="needs the extra opensim")

opensim.Logger.setLevelString("Off")
DURATION = 0.1
ACCURACY, FINER = 1e-3, 1e-5
STEP = 2.5e-4


def theirs(file: Path, names: list[str], accuracy: float) -> tuple[float, FloatArray, FloatArray]:
    """Return processor time, final coordinates, and start (q, activations, fibre lengths)."""
    model = opensim.Model(str(file))
    state = model.initSystem()
    model.equilibrateMuscles(state)
    coordinates = [model.getCoordinateSet().get(name) for name in names]
    muscles = [model.getMuscles().get(k) for k in range(model.getMuscles().getSize())]
    start = np.array(
        [c.getValue(state) for c in coordinates]
        + [x for m in muscles for x in (m.getActivation(state), m.getFiberLength(state))]
    )
    manager = opensim.Manager(model)
    manager.setIntegratorMethod(opensim.Manager.IntegratorMethod_RungeKuttaMerson)
    manager.setIntegratorAccuracy(accuracy)
    manager.initialize(state)
    begin = time.process_time()
    state = manager.integrate(DURATION)
    spent = time.process_time() - begin
    return spent, np.array([c.getValue(state) for c in coordinates]), start


def ours(robot: Robot, start: FloatArray, step: float) -> tuple[float, FloatArray]:
    """Return processor time and final coordinates."""
    n, steps = len(robot.coordinates), round(DURATION / step)
    plant = Plant(robot, DURATION, integrator="rk4", substeps=steps, engine="core")
    plant.reset(start[:n])
    state = plant.get_state()
    state[1 + 2 * n : 1 + 2 * n + len(start) - n] = start[n:]
    plant.set_state(state)
    begin = time.process_time()
    plant.step(np.full(len(robot.muscles), 0.01))
    return time.process_time() - begin, np.array(plant.q)


def test_full_body_is_five_times_faster_than_opensim(shared: Path) -> None:
    file = shared / "models/opensim/subject_walk_scaled.osim"
    robot = read_robot(file)
    joints = tuple(
        replace(
            joint,
            coordinates=tuple(
                replace(c, lower=-math.inf, upper=math.inf) for c in joint.coordinates
            ),
        )
        for joint in robot.joints
    )
    robot = replace(robot, joints=joints)
    names = [c.name for c in robot.coordinates]
    spent, end, start = theirs(file, names, ACCURACY)
    _, finer, _ = theirs(file, names, FINER)
    our_time, our_end = ours(robot, start, STEP)
    _, our_finer = ours(robot, start, STEP / 4)
    error, our_error = (float(np.abs(a - b).max()) for a, b in ((end, finer), (our_end, our_finer)))
    ratio = spent / our_time
    record(
        "OpenSim's full body, 0.1 s", s=our_time, opensim_over_ours=ratio, error=our_error,
        opensims_error=error,
    )  # fmt: skip
    assert our_error <= error
    assert ratio > 5.0
