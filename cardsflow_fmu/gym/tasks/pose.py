"""Pose task: bring the joints to a target pose. The terms are those of MyoSuite's pose task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from cardsflow_fmu.utils.arrays import FloatArray

from .task import Start, Task

StartPose = Literal["initial", "random"]


class PoseTask(Task):
    """Task to bring joints to a pose.

    The term `pose` is minus the distance in joint space. The bonus begins at 1.5 thresholds.

    Args:
        robot: The robot.
        targets: Ranges of the target by coordinate; other coordinates are free.
        threshold: Distance below which the task is solved, in [rad] or [m].
        far: Distance at which an episode ends.
        start: Whether an episode starts in the initial pose or in a random one.
        weights: Changes of the weights of the reward terms.

    Raises:
        InputError: A range or a threshold is invalid.
        UnknownNameError: A coordinate or a reward term does not exist.
    """

    term, layout = "pose", ("error",)
    bonus_range = 1.5
    default_weights: ClassVar = {"pose": 1.0, "bonus": 4.0, "act_reg": 1.0, "penalty": 50.0}

    def __init__(
        self,
        robot: Robot,
        targets: Mapping[str, Sequence[float]] | None = None,
        threshold: float = 0.35,
        far: float = 2.0 * np.pi,
        start: StartPose = "initial",
        weights: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(robot, weights, threshold, far)
        if start not in ("initial", "random"):
            raise InputError(f"start must be 'initial' or 'random', not {start!r}")
        ranges = {c.name: (c.lower, c.upper) for c in robot.coordinates}
        targets = ranges if targets is None else targets
        self.choose("coordinate", list(ranges), targets)
        self._low, self._high = bounds("targets", targets)
        self._poses = limits(robot) if start == "random" else (self.initial, self.initial)

    def start(self) -> Start:
        """Return the ranges of the targets and of the start poses."""
        return Start(np.array(self._poses), np.array([self._low, self._high]))


def bounds(label: str, ranges: Mapping[str, ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper ends of ranges.

    Raises:
        InputError: A range is not (low, high) with finite numbers in this order.
    """
    if not ranges:
        raise InputError(f"{label} must not be empty; name at least one coordinate or point")
    low, high = [], []
    for name, pair in ranges.items():
        try:
            a, b = (np.asarray(end, dtype=np.float64) for end in pair)  # type: ignore[union-attr]
        except (TypeError, ValueError):
            raise InputError(f"{label}: {name!r} must be (low, high), not {pair!r}") from None
        if a.shape != b.shape or not (np.isfinite(a).all() and np.isfinite(b).all()):
            raise InputError(f"{label}: {name!r} must have finite ends, not {pair!r}")
        if (a > b).any():
            raise InputError(f"{label}: {name!r} must begin below its end, not {pair!r}")
        low.append(a.reshape(-1))
        high.append(b.reshape(-1))
    return np.concatenate(low), np.concatenate(high)


def limits(
    robot: Robot, ranges: Mapping[str, ArrayLike] | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the ends of ranges of all coordinates.

    Args:
        robot: The robot.
        ranges: Ranges by coordinate (default: joint limits).

    Raises:
        InputError: A range is invalid, or a coordinate is not limited.
        UnknownNameError: A coordinate does not exist.
    """
    limits_by_name: dict[str, ArrayLike] = {c.name: (c.lower, c.upper) for c in robot.coordinates}
    for name, pair in (ranges or {}).items():
        if name not in limits_by_name:
            raise UnknownNameError("coordinate", name, limits_by_name)
        limits_by_name[name] = pair
    for name, pair in limits_by_name.items():
        if name not in (ranges or {}) and not np.isfinite(pair).all():
            raise InputError(f"random poses need limits; coordinate {name!r} has none")
    return bounds("poses", limits_by_name)
