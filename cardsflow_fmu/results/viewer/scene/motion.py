"""Motion of a run at a constant frame rate."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from addin_sdfusion.robot import InputError, Link, Robot, TaskFrame
from cardsflow_fmu.cosim.signals.ports import (
    TORQUE,
    coordinate_signals,
    identifier,
    motor_signals,
    muscle_signals,
    signal_names,
)
from cardsflow_fmu.cosim.signals.reaction import FAULTS
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.utils.arrays import BoolArray, FloatArray
from sim_dart.scene import Scene

_MAX_DISTANCE = 1e9
_BROKEN = next(number for number, kind in FAULTS.items() if kind == "broken")

RATE = 25.0
"""Frame rate of a replay, in [1/s]."""
MAX_FRAMES = 25_000
"""Maximum number of frames; longer runs have a lower frame rate."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a robot at K frames.

    Attributes:
        time: Times, shape (K,), in [s].
        q: Joint positions, shape (K, n), in [rad] or [m].
        tensions: Muscle forces, shape (K, m), in [N]; None if unknown.
        q_d: Desired joint positions, shape (K, n), in [rad] or [m]; None if unknown.
        y_d: Desired positions of end-effector points, shape (K, 3), in [m], by task frame; nan
            for axes without reference.
        contacts: Contact force on a link or object in world axes, shape (K, 3), in [N], by name.
        objects: Poses of the moving objects, shape (K, 4, 4), by name.
        torques: Torques or forces of joint motors, shape (K, motors), in [N·m] or [N]; None if
            unknown.
        broken: Whether each cable is known to be broken, shape (K, m); None without detection.
    """

    time: FloatArray
    q: FloatArray
    tensions: FloatArray | None = None
    q_d: FloatArray | None = None
    y_d: dict[str, FloatArray] = field(default_factory=dict)
    contacts: dict[str, FloatArray] = field(default_factory=dict)
    objects: dict[str, FloatArray] = field(default_factory=dict)
    torques: FloatArray | None = None
    broken: BoolArray | None = None

    @staticmethod
    def still(q: ArrayLike) -> Motion:
        """Return a single frame at joint positions q, without forces."""
        return Motion(np.zeros(1), np.atleast_2d(np.asarray(q, dtype=np.float64)))

    @staticmethod
    def initial(robot: Robot) -> Motion:
        """Return a single frame at the initial pose, within the joint limits."""
        return Motion.still([min(max(c.initial, c.lower), c.upper) for c in robot.coordinates])


def frame_rows(time: FloatArray, rate: float = RATE) -> NDArray[np.int64]:
    """Return the rows of a result for a constant frame rate; the last row is always included.

    Args:
        time: Increasing times of the rows, shape (rows,), in [s].
        rate: Frame rate, in [1/s].
    """
    if not len(time):
        return np.zeros(0, dtype=np.int64)
    interval = max(1.0 / rate, (time[-1] - time[0]) / MAX_FRAMES)
    due = np.arange(time[0], time[-1], interval)
    rows = np.searchsorted(time, due - 0.5 * np.min(np.diff(time), initial=interval))
    return np.unique(np.append(rows, len(time) - 1))


def motion_of(
    robot: Robot,
    result: RunData,
    rows: NDArray[np.int64] | None = None,
    world: Scene | None = None,
) -> Motion:
    """Return the motion in a result.

    Raises:
        InputError: The result has no rows, or a joint position is missing.
    """
    if not len(result.rows):
        raise InputError("the run has no rows")
    rows = frame_rows(result["time"]) if rows is None else rows
    columns = _Columns(result, rows)
    q = columns.all(coordinate_signals("q", robot))
    if q is None:
        missing = next(n for n in coordinate_signals("q", robot) if n not in result.names)
        raise InputError(f"the results have no column {missing!r}, which a view requires")
    faults = columns.any(muscle_signals("fault", robot))
    return Motion(
        result["time"][rows],
        q,
        columns.all(_tensions(robot, result)),
        columns.all(coordinate_signals("q_d", robot)),
        _desired_points(robot, columns),
        _contacts(robot.links, world, columns),
        {} if world is None else _objects(world, columns),
        columns.all(motor_signals(TORQUE, robot)),
        None if faults is None else faults == _BROKEN,
    )


_NOT_SHOWN = ("time", "qd.", "qd_d.", "qdd_d.", "yd_d.", "ydd_d.", "contact.", "object.")
"""Prefixes of signals that no plot of a page shows."""


def shown_signals(result: RunData) -> dict[str, FloatArray]:
    """Return the signals that a page shows, at the rows of `frame_rows`, by name."""
    rows = frame_rows(result["time"])
    names = [name for name in result.names if not name.startswith(_NOT_SHOWN)]
    columns = drop_huge_values(result.columns(names)[rows])
    return dict(zip(names, columns.T, strict=True))


def _tensions(robot: Robot, result: RunData) -> list[str]:
    """Return the columns of recorded tensions, or of commands if tensions are not recorded."""
    pairs = zip(muscle_signals("tension", robot), muscle_signals("f", robot), strict=True)
    return [actual if actual in result.names else desired for actual, desired in pairs]


def drop_huge_values(values: FloatArray) -> FloatArray:
    """Replace values by nan if they are too large to draw, as in a diverged run."""
    within = np.abs(values) < _MAX_DISTANCE
    return values if within.all() else np.where(within, values, np.nan)


class _Columns:
    """Columns at the selected rows."""

    def __init__(self, result: RunData, rows: NDArray[np.int64]) -> None:
        self._result, self._rows = result, rows

    def all(self, names: list[str]) -> FloatArray | None:
        """Return the columns, shape (K, len(names)); None if one is missing."""
        if not set(names) <= set(self._result.names):
            return None
        if not names:
            return np.zeros((len(self._rows), 0))
        return drop_huge_values(self._result.columns(names)[self._rows])

    def any(self, names: list[str]) -> FloatArray | None:
        """Return the columns, with nan for missing columns; None if all are missing."""
        columns = [self.all([name]) for name in names]
        if all(column is None for column in columns):
            return None
        nothing = np.full((len(self._rows), 1), np.nan)
        return np.hstack([nothing if column is None else column for column in columns])


def task_points(robot: Robot) -> list[TaskFrame]:
    """Return the task frames that are points; the first one is the end effector."""
    return [frame for frame in robot.task_frames if not frame.is_orientation]


def _desired_points(robot: Robot, columns: _Columns) -> dict[str, FloatArray]:
    frames = task_points(robot)
    names = signal_names("y_d", [frame.name for frame in frames])
    points_by_name = {
        frame.name: columns.any([f"{name}.{axis}" for axis in "xyz"])
        for frame, name in zip(frames, names, strict=True)
    }
    return {name: points for name, points in points_by_name.items() if points is not None}


def _contacts(
    links: tuple[Link, ...], world: Scene | None, columns: _Columns
) -> dict[str, FloatArray]:
    names = [link.name for link in links]
    names += [] if world is None else [item.name for item in world.objects]
    forces_by_name = {
        name: columns.all([f"contact.{identifier(name)}.f{axis}" for axis in "xyz"])
        for name in names
    }
    return {name: forces for name, forces in forces_by_name.items() if forces is not None}


def _objects(world: Scene, columns: _Columns) -> dict[str, FloatArray]:
    """Return the poses of the moving objects that the results contain."""
    names = [item.name for item in world.moving_objects]
    signals = signal_names("object", names)
    axes = (*"xyz", "qx", "qy", "qz", "qw")
    values_by_name = {
        name: columns.all([f"{signal}.{axis}" for axis in axes])
        for name, signal in zip(names, signals, strict=True)
    }
    return {name: _poses(values) for name, values in values_by_name.items() if values is not None}


def _poses(values: FloatArray) -> FloatArray:
    """Convert positions and quaternions (x, y, z, w), shape (K, 7), to poses, shape (K, 4, 4)."""
    turns = np.nan_to_num(values[:, 3:])
    turns[~turns.any(axis=1)] = (0.0, 0.0, 0.0, 1.0)
    T = np.tile(np.eye(4), (len(values), 1, 1))
    T[:, :3, :3] = Rotation.from_quat(turns).as_matrix()
    T[:, :3, 3] = values[:, :3]
    return T
