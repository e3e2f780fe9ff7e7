"""Commands of muscles in equilibrium at the start of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.force_distribution.gravity_compensation import gravity_compensation
from sim_dart import MuscleDrive, control_dynamics


class Start(NamedTuple):
    """Commands and tensions of muscles at the start.

    Attributes:
        commands: Commands of all muscles, shape (m,), each in the unit of its law; empty if all
            muscles are ideal cables.
        forces: Tensions under these commands, shape (m,), in [N]; f_min if all are ideal cables.
    """

    commands: tuple[float, ...]
    forces: FloatArray


def start(robot: Robot, q: Sequence[float]) -> Start:
    """Return commands that hold the robot at rest, as closely as possible.

    A muscle with a law cannot change its tension instantly, so with slack muscles the robot would
    fall at the start of a run.

    Args:
        robot: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
    """
    f_min = np.array([muscle.f_min for muscle in robot.muscles])
    if not modelled_muscles(robot):
        return Start((), f_min)
    f_max = np.array([muscle.f_max for muscle in robot.muscles])
    drive, dynamics = MuscleDrive(robot), control_dynamics(robot)
    at_rest = drive.resting_reach(q)
    low = np.maximum(np.clip(f_min, at_rest.low, at_rest.high), 0.0)
    high = np.maximum(np.clip(f_max, at_rest.low, at_rest.high), 0.0)
    motors = [(motor.tau_min, motor.tau_max) for motor in robot.motors]
    weakest, strongest = np.array(motors).reshape(-1, 2).T
    bounds = np.concatenate([low, weakest]), np.concatenate([high, strongest])
    held = gravity_compensation(dynamics, np.array(q), *bounds)[: len(robot.muscles)]
    return Start(tuple(drive.resting_commands(q, held).tolist()), held)
