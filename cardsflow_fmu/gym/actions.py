"""Actions from -1 to 1, and the commands of muscles and motors that they mean."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import Batch
from sim_dart.batch.episodes import ACTION

ActionMap = Literal["auto", "sigmoid", "range"]


class Actions:
    """Commands of a batch for actions of shape (n, k): one for each driven muscle, then motor.

    The map `range` is linear: -1 is the smallest command and 1 the largest. The command of an ideal
    cable is a tension from f_min to f_max. The map `sigmoid` is that of MyoSuite, the excitation
    1 / (1 + exp(-5 (a - 0.5))), for muscles with excitations from 0 to 1. `auto` is `sigmoid` if
    all muscles have excitations, otherwise `range`. Motors always use `range`.

    Args:
        robot: The robot.
        batch: A batch of this robot, for the ranges of the commands.
        kind: The map.

    Attributes:
        size: Number of actions.
        rest: The smallest commands, shape (m,), with which muscles start.
        is_sigmoid: Whether the map is `sigmoid`.
        table: Ranges of the commands, for `Rules` of episodes.
    """

    def __init__(self, robot: Robot, batch: Batch, kind: ActionMap = "auto") -> None:
        if kind not in get_args(ActionMap):
            raise InputError(f"action must be one of {get_args(ActionMap)}, not {kind!r}")
        names = batch.command_names
        driven = [k for k, name in enumerate(names) if name]
        excited = [names[k] == "excitation" for k in driven]
        if kind == "sigmoid" and not all(excited):
            raise InputError(
                f"action = 'sigmoid' needs muscles with excitations, but muscle "
                f"{robot.muscles[driven[excited.index(False)]].name!r} has none; use 'range'"
            )
        self.is_sigmoid = kind != "range" and bool(excited) and all(excited)
        low, high = _command_ranges(robot, batch)
        self._low, self._high = low[driven], high[driven]
        motors = [c for c in robot.coordinates if c.actuated]
        self._names = [robot.muscles[k].name for k in driven] + [c.name for c in motors]
        self._tau = np.array([(c.tau_min, c.tau_max) for c in motors]).reshape(-1, 2)
        for motor, limits in zip(motors, self._tau, strict=True):
            if not np.isfinite(limits).all():
                raise InputError(f"motor {motor.name!r} needs limits of its torque for actions")
        self.size = len(driven) + len(motors)
        if not self.size:
            raise InputError(f"robot {robot.name!r} has neither driven muscles nor motors")
        self.rest = low
        coordinates = [k for k, c in enumerate(robot.coordinates) if c.actuated]
        self.table = np.zeros(self.size, ACTION)
        self.table["muscle"] = [*driven, *[-1] * len(motors)]
        self.table["dof"] = [*[-1] * len(driven), *coordinates]
        self.table["low"], self.table["high"] = self.ranges()[1:3]

    def ranges(self) -> tuple[list[str], FloatArray, FloatArray, FloatArray]:
        """Return names, smallest, largest and resting commands of the actions."""
        low, high = (
            np.concatenate(ends) for ends in zip((self._low, self._high), self._tau.T, strict=True)
        )
        rest = np.concatenate([self._low, np.clip(0.0, *self._tau.T)])
        return self._names, low, high, rest


def _command_ranges(robot: Robot, batch: Batch) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and largest commands of actions, shape (m,)."""
    low, high = batch.command_low.copy(), batch.command_high.copy()
    for k, muscle in enumerate(robot.muscles):
        if not np.isfinite(high[k]) and batch.command_names[k]:
            low[k], high[k] = max(muscle.f_min, low[k]), muscle.f_max
            if not np.isfinite(high[k]):
                raise InputError(f"muscle {muscle.name!r} needs f_max for actions; set it")
    return low, high
