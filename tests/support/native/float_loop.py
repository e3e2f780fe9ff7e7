"""Closed loop of an example: the controller of the firmware in either precision, and the plant."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cardsflow_fmu import Experiment
from cardsflow_fmu.models.reference import make_reference
from sim_dart import DartDynamics, Plant

from .example import write_example
from .precision import Precision

FloatArray = NDArray[np.float64]
SOLVED, SOFT = 0, 1


class Run(NamedTuple):
    """Recording of a closed loop.

    Attributes:
        q: Coordinates, shape (ticks, n).
        forces: Muscle forces, shape (ticks, m), in [N].
        errors: Tracking errors, in [rad] or [m], shape (ticks, r).
        statuses: Statuses of the control law.
    """

    q: FloatArray
    forces: FloatArray
    errors: FloatArray
    statuses: NDArray[np.int64]

    @property
    def rms(self) -> float:
        """RMS of the norm of the tracking error over time."""
        return float(np.sqrt((self.errors**2).sum(axis=1).mean()))


def run_loop(
    folder: Path, experiment: Experiment, duration: float, *, single: bool, begin: float = 0.0
) -> Run:
    """Run the controller of the firmware with the plant in double precision.

    The run has a duration and starts at a time of the reference, both in [s]. The controller is
    compiled in a folder.
    """
    folder.mkdir(exist_ok=True)
    write_example(folder / "example.h", experiment, single=single)
    code = Precision(folder, single, ("example_loop.c",))
    assert not code.call("example_open")
    loop = ctypes.c_void_p.in_dll(code.library, "loop")
    code.library.control_loop_array.restype = ctypes.c_void_p
    settings, robot = experiment.controller, experiment.robot
    n, m = len(robot.coordinates), len(robot.muscles)
    acting = code.view(
        code.library.control_loop_array(loop, b"acting", ctypes.byref(ctypes.c_size_t())), m
    )
    plant = Plant(robot, experiment.plant.step, engine="core")
    plant.reset(experiment.start.q, experiment.start.qd)
    dynamics, reference = DartDynamics(robot), make_reference(experiment)
    still = code.numbers(np.zeros(n))
    steps = round(settings.period / experiment.plant.step)
    found: list[list[FloatArray]] = [[], [], []]
    statuses = []
    for tick in range(round(duration / settings.period)):
        row = np.array(reference.evaluate(begin + settings.period * tick)[:3])
        at = plant.q if settings.space == "joint" else dynamics.task_position(plant.q)
        state = (code.numbers(plant.q), code.numbers(plant.qd), code.numbers(row))
        statuses.append(code.call("control_loop_tick", loop, float(settings.period), *state, still))
        forces = acting.astype(float)
        for kept, values in zip(found, (plant.q, forces, row[0] - at), strict=True):
            kept.append(np.array(values))
        for _ in range(steps):
            plant.step(forces)
    return Run(*map(np.array, found), np.array(statuses))
