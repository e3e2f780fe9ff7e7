"""Tracking task: follow the reference of an experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.utils.arrays import FloatArray

from .task import Start, Task


class TrackTask(Task):
    """Task to follow a reference in joint space or operational space.

    The term `track` is minus the distance to the reference; the bonus begins at two thresholds.

    Args:
        robot: The robot.
        start: Joint positions at the start, shape (dofs,).
        reference: Desired positions at every step of an episode, shape (steps + 1, k).
        moves: Desired velocities times the length of a step, shape (steps + 1, k).
        space: `joint` or `operational`.
        threshold: Distance below which the task is solved, in [rad] or [m].
        far: Distance at which an episode ends.
        weights: Changes of the weights of the reward terms.
    """

    term = "track"
    default_weights: ClassVar = {"track": 1.0, "bonus": 4.0, "act_reg": 1.0, "penalty": 50.0}

    def __init__(
        self,
        robot: Robot,
        start: FloatArray,
        reference: FloatArray,
        moves: FloatArray,
        space: Space,
        threshold: float,
        far: float,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(robot, weights, threshold, far)
        if not np.isfinite(reference).all():
            raise InputError("the reference must be finite")
        self.reference: FloatArray = np.hstack([reference, moves])
        self._start = start
        self.space = space
        self.layout = ("error", "rate") if space == "joint" else ("y", "error", "rate")

    def start(self) -> Start:
        """Return the start of the reference."""
        return Start(np.array(2 * [self._start]), self.reference[[0, 0]])
