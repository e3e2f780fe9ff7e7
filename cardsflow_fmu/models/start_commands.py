"""Muscle commands that hold a robot at the start of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.muscles import modelled_muscles
from cardsflow_fmu.experiment.motion.feedback import MotionFeedback
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.force_distribution.gravity_compensation import gravity_compensation
from sim_dart import MuscleDrive, control_dynamics


class Start(NamedTuple):
    """Muscle commands and forces at the start of a run.

    Attributes:
        commands: Commands of all muscles, shape (m,), in the units of their muscle laws; empty if
            all muscles are ideal cables.
        forces: Forces for these commands, shape (m,), in [N]; f_min if all muscles are ideal
            cables.
    """

    commands: tuple[float, ...]
    forces: FloatArray


def start(robot: Robot, q: Sequence[float], feedback: MotionFeedback | None = None) -> Start:
    """Compute commands that hold the robot at rest, or minimise its acceleration.

    The force of a muscle with a muscle law cannot change instantly. With slack muscles the robot
    would therefore fall at the start of a run.

    Args:
        q: Joint positions, shape (n,), in [rad] or [m].
        feedback: An optimal motion, which starts with its own activations.
    """
    f_min = np.array([muscle.f_min for muscle in robot.muscles])
    if not modelled_muscles(robot):
        return Start((), f_min)
    drive, dynamics, m = MuscleDrive(robot), control_dynamics(robot), len(robot.muscles)
    reach = drive.resting_reach(q)
    limits = dynamics.f_min.copy(), dynamics.f_max.copy()
    for limit in limits:
        limit[:m] = np.maximum(np.clip(limit[:m], reach.low, reach.high), 0.0)
    forces = gravity_compensation(dynamics, np.array(q), *limits)[:m]
    commands = drive.resting_commands(q, forces).tolist()
    if feedback is not None:
        first = dict(zip(feedback.state_names, feedback.states[0].tolist(), strict=True))
        pairs = zip(robot.muscles, commands, strict=True)
        commands = [first.get(f"activation.{muscle.name}", u) for muscle, u in pairs]
    return Start(tuple(commands), forces)
