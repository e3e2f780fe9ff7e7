"""Reach task: bring end-effector points to targets. The terms are those of MyoSuite's reach."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart import Batch

from .pose import bounds, limits
from .task import Start, Task

Sampling = Literal["box", "workspace"]

_POSES = 100_000
_CHUNK = 1000


class ReachTask(Task):
    """Task to bring k end-effector points to targets.

    The term `reach` is minus the distance over all points. The task is solved below k thresholds,
    the bonus begins at 2 k thresholds. Episodes end beyond k `far`, after the first two steps.

    Args:
        robot: The robot. Its active task set contains the points.
        targets: Boxes of the targets (low, high), in [m], by task frame (default: infinite boxes
            for all points, with the sampling `workspace`).
        sampling: `box` draws targets in the boxes. `workspace` draws reachable ones: positions
            at random poses that lie in the boxes.
        poses: Ranges of coordinates at random poses (default: joint limits).
        threshold: Distance for each point below which the task is solved, in [m].
        far: Distance for each point at which an episode ends, in [m].
        weights: Changes of the weights of the reward terms.

    Raises:
        InputError: A range or a threshold is invalid, or no pose reaches the boxes.
        UnknownNameError: A task frame or a reward term does not exist.
    """

    term, first_end, layout = "reach", 3, ("y", "error")
    default_weights: ClassVar = {"reach": 1.0, "bonus": 4.0, "act_reg": 0.0, "penalty": 50.0}

    def __init__(
        self,
        robot: Robot,
        targets: Mapping[str, ArrayLike] | None = None,
        sampling: Sampling = "box",
        poses: Mapping[str, ArrayLike] | None = None,
        threshold: float = 0.0125,
        far: float = 0.35,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        if sampling not in ("box", "workspace"):
            raise InputError(f"sampling must be 'box' or 'workspace', not {sampling!r}")
        points = [f.name for f in robot.task_frames if not f.is_orientation]
        if not points:
            raise InputError(
                f"robot {robot.name!r} has no points to reach; set robot.operational_space, "
                "or choose another task"
            )
        names = points if targets is None else list(targets)
        super().__init__(robot, weights, threshold, far, len(names))
        owners = [frame.name for frame in robot.task_frames for _ in frame.axes]
        columns = self.choose("task frame", owners, names)
        if targets is None:
            sampling = "workspace"
            self._high = np.full(len(columns), np.inf)
            self._low = -self._high
        else:
            self._low, self._high = bounds("targets", targets)
        if self._low.size != len(columns):
            raise InputError(
                f"targets: the boxes have {self._low.size} numbers, but the points have "
                f"{len(columns)} coordinates"
            )
        self.space = "operational"
        self._points = self._reachable(columns, poses or {}) if sampling == "workspace" else None

    def start(self) -> Start:
        """Return the initial pose, and the boxes of the targets or reachable targets."""
        return Start(np.array(2 * [self.initial]), np.array([self._low, self._high]), self._points)

    def _reachable(self, columns: list[int], ranges: Mapping[str, ArrayLike]) -> FloatArray:
        """Return positions of the points at random poses, shape (k, 3 points)."""
        rng, (low, high) = np.random.default_rng(0), limits(self.robot, ranges)
        poses = np.stack([rng.uniform(a, b, _POSES) for a, b in zip(low, high, strict=True)], 1)
        batch, positions = Batch(self.robot, _CHUNK), []
        rest = np.maximum(batch.command_low, 0.0)
        for k in range(0, _POSES, _CHUNK):
            batch.reset(q=poses[k : k + _CHUNK], commands=rest)
            positions.append(batch.task_position[:, columns])
        points = np.concatenate(positions)
        inside = ((points >= self._low) & (points <= self._high)).all(axis=1)
        if not inside.any():
            raise InputError("targets: no pose of the robot brings the points into the boxes")
        return points[inside]
