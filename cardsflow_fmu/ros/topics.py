"""Topics with one message per row of a run: its columns as joint states and signals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.cosim.signals.hardware import MEASURED_TORQUE
from cardsflow_fmu.cosim.signals.muscles import command_ports
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME, TORQUE, identifier, slack_signals
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.ros_interface import message_types as types
from cardsflow_fmu.ros_interface.node import Topic, Values, header
from cardsflow_fmu.utils.arrays import FloatArray

JOINT_STATES = Topic("/joint_states", types.JOINT_STATE)
JOINT_REFERENCE = Topic("/joint_reference", types.JOINT_STATE)
JOINT_COMMANDS = Topic("/joint_commands", types.JOINT_STATE)
TENDON_STATES = Topic("/tendon_states", types.JOINT_STATE)
TENDON_COMMANDS = Topic("/tendon_commands", types.JOINT_STATE)
TASK_STATES = Topic("/task_states", types.JOINT_STATE)
TASK_REFERENCE = Topic("/task_reference", types.JOINT_STATE)
SIGNALS = Topic("/signals", types.SIGNALS)

_TICK_TIME = "solve_time"
"""Signal with the computing time of a controller tick, if the run has measured it."""
_MAX_TIME = 2.0**63 - 1024.0
"""Maximum time of messages, in [ns]. Later and invalid times are clipped to it."""


class Batch(NamedTuple):
    """Messages of one topic that differ only in their numbers.

    Attributes:
        time_ns: Times of K messages, shape (K,), in [ns].
        values: Fields of the messages. Arrays have K rows; all other values are equal in all
            messages. An array of shape (K, n, 3) contains n points.
    """

    topic: Topic
    time_ns: NDArray[np.int64]
    values: Values


def nanoseconds(time: FloatArray) -> NDArray[np.int64]:
    """Return times in [s] as integers in [ns]."""
    with np.errstate(over="ignore"):
        rounded = np.nan_to_num(np.rint(1e9 * time), nan=_MAX_TIME)
    times: NDArray[np.int64] = np.clip(rounded, -_MAX_TIME, _MAX_TIME).astype(np.int64)
    return times


class RowTopics:
    """Topics with one message per row.

    Args:
        robot: Robot of the run, or None if unknown. Without a robot, the names of the columns are
            used, and efforts and rates of lengths are omitted.
    """

    def __init__(self, run: RunData, robot: Robot | None = None) -> None:
        self._run, self._robot = run, robot
        units = _units(robot) if robot is not None else {}
        self._units = units | {_TICK_TIME: "s"} | dict(run.units)
        self._columns = {name: k for k, name in enumerate(run.names)}
        joints = None if robot is None else [c.name for c in robot.coordinates]
        motors = None if robot is None else [c.name for c in robot.motors]
        muscles = None if robot is None else [muscle.name for muscle in robot.muscles]
        self._joints = self._names(("q",), joints)
        self._desired = self._names(("q_d",), joints)
        self._motors = self._names((TORQUE,), motors)
        self._muscles = self._names(("tension", "f", "l"), muscles)
        self._driven = self._names(("f",), muscles)
        self._tasks = self._names(("y",), None)
        self._task_references = self._names(("y_d",), None)
        self._signals = self._other_columns()
        self._paths = _PathMotion(robot, self._columns) if robot is not None else None
        tables = self._tables(_Rows(run, self._columns, slice(0)))
        self.topics = (*(table.topic for table in tables), *([SIGNALS] if self._signals else []))

    def replace(self, run: RunData) -> None:
        """Replace the run by another one with the same columns."""
        self._run = run

    def batches(self, first: int, end: int) -> Iterator[Batch]:
        """Yield the messages of the rows from `first` to `end` (exclusive), topic by topic."""
        rows = _Rows(self._run, self._columns, slice(first, end))
        times = nanoseconds(rows.time)
        for table in self._tables(rows):
            yield table.batch(times)
        if self._signals:
            yield self._signal_batch(rows, times)

    def _signal_batch(self, rows: _Rows, time_ns: NDArray[np.int64]) -> Batch:
        """Return the messages with all other columns and the computing times of ticks."""
        names, values = list(self._signals), rows.columns(self._signals)
        ticks = None if SOLVE_TIME in self._columns else rows.tick_times()
        if ticks is not None:
            names, values = [*names, _TICK_TIME], np.column_stack([values, ticks])
        units = [self._units.get(name, "") for name in names]
        fields = {"header": header(time_ns), "name": names, "unit": units, "value": values}
        return Batch(SIGNALS, time_ns, fields)

    def _tables(self, rows: _Rows) -> list[_Table]:
        """Return the topics of joint states.

        For tendons, position is the length l, velocity is l', and effort is the force f.
        """
        rates, efforts = self._paths.motion(rows) if self._paths is not None else (None, None)
        tables = [
            _Table(
                JOINT_STATES,
                self._joints,
                rows.prefixed("q", self._joints),
                rows.prefixed_if_complete("qd", self._joints),
                efforts,
            ),
            _Table(
                JOINT_REFERENCE,
                self._desired,
                rows.prefixed("q_d", self._desired),
                rows.prefixed_if_complete("qd_d", self._desired),
            ),
            _Table(JOINT_COMMANDS, self._motors, effort=rows.prefixed(TORQUE, self._motors)),
            _Table(
                TENDON_STATES,
                self._muscles,
                rows.prefixed("l", self._muscles),
                rates,
                rows.first_available(("tension", "f"), self._muscles),
            ),
            _Table(TENDON_COMMANDS, self._driven, effort=rows.prefixed("f", self._driven)),
            _Table(TASK_STATES, self._tasks, rows.prefixed("y", self._tasks)),
            _Table(
                TASK_REFERENCE, self._task_references, rows.prefixed("y_d", self._task_references)
            ),
        ]
        return [table for table in tables if table.names]

    def _names(self, prefixes: Sequence[str], names: Sequence[str] | None) -> dict[str, str]:
        """Return the names of objects that have columns with one of the prefixes.

        Returns:
            Names of the objects by the identifiers that columns contain.
        """
        in_columns = {
            name.partition(".")[2]: name.partition(".")[2]
            for name in self._columns
            if name.partition(".")[0] in prefixes and "." in name
        }
        if names is None or not in_columns:
            return in_columns
        return {identifier(name): name for name in names}

    def _other_columns(self) -> list[str]:
        """Return the names of columns that no topic of joint states contains."""
        published = {"time"}
        measured = (MEASURED_TORQUE,) if self._robot is not None else ()
        for prefixes, names in (
            (("q", "qd", *measured), self._joints),
            (("q_d", "qd_d"), self._desired),
            ((TORQUE,), self._motors),
            (("f", "tension", "l"), self._muscles),
            (("y",), self._tasks),
            (("y_d",), self._task_references),
        ):
            published |= {f"{prefix}.{name}" for prefix in prefixes for name in names}
        return [name for name in self._columns if name not in published]


class _Table(NamedTuple):
    """Joint states of one topic, with one message per row.

    Attributes:
        names: Names of the joints by the identifiers that columns contain.
        position, velocity, effort: Values, shape (K, n) each, or None to omit them.
    """

    topic: Topic
    names: Mapping[str, str]
    position: FloatArray | None = None
    velocity: FloatArray | None = None
    effort: FloatArray | None = None

    def batch(self, time_ns: NDArray[np.int64]) -> Batch:
        """Return the messages, at times of shape (K,), in [ns]."""
        fields = {"position": self.position, "velocity": self.velocity, "effort": self.effort}
        columns = {field: table for field, table in fields.items() if table is not None}
        names = tuple(self.names.values())
        return Batch(self.topic, time_ns, {"header": header(time_ns), "name": names, **columns})


class _Rows:
    """Columns in a range of rows."""

    def __init__(self, run: RunData, indices: Mapping[str, int], rows: slice) -> None:
        self._run, self._indices = run, indices
        self._values = run.rows[rows]
        self.time = self._values[:, indices["time"]]

    def columns(self, names: Sequence[str]) -> FloatArray:
        """Return columns by their full names, shape (K, n). Missing columns are NaN."""
        values = np.full((len(self._values), len(names)), np.nan)
        available = [k for k, name in enumerate(names) if name in self._indices]
        values[:, available] = self._values[:, [self._indices[names[k]] for k in available]]
        return values

    def prefixed(self, prefix: str, names: Mapping[str, str]) -> FloatArray:
        """Return the columns with a prefix, shape (K, n). Missing columns are NaN."""
        return self.columns([f"{prefix}.{name}" for name in names])

    def prefixed_if_complete(self, prefix: str, names: Mapping[str, str]) -> FloatArray | None:
        """Return the columns with a prefix, shape (K, n), or None if a column is missing."""
        columns = [f"{prefix}.{name}" for name in names]
        return self.columns(columns) if set(columns) <= set(self._indices) else None

    def first_available(self, prefixes: Sequence[str], names: Mapping[str, str]) -> FloatArray:
        """Return for each name the column with the first existing prefix, shape (K, n)."""
        columns = [
            next((f"{p}.{name}" for p in prefixes if f"{p}.{name}" in self._indices), "")
            for name in names
        ]
        return self.columns(columns)

    def tick_times(self) -> FloatArray | None:
        """Return the computing time of each row's tick, in [s], or None if not measured.

        Rows without a tick are NaN.
        """
        ticks = self._run.solve_times
        if not len(ticks) or not len(self.time):
            return None
        durations = np.full(len(self.time), np.nan)
        tick_ns, row_ns = nanoseconds(ticks[:, 0]), nanoseconds(self.time)
        k = np.minimum(np.searchsorted(tick_ns, row_ns), len(ticks) - 1)
        has_tick = tick_ns[k] == row_ns
        durations[has_tick] = ticks[k[has_tick], 1]
        return durations


class _PathMotion:
    """Rates of muscle lengths and joint efforts along the motion."""

    def __init__(self, robot: Robot, columns: Mapping[str, int]) -> None:
        from sim_dart import MusclePaths

        self._joints = {identifier(c.name): c.name for c in robot.coordinates}
        self._muscles = {identifier(m.name): m.name for m in robot.muscles}
        self._motors = {identifier(motor.name): motor.name for motor in robot.motors}
        self._motor_indices = [robot.coordinates.index(motor) for motor in robot.motors]
        self._has_qd = all(f"{p}.{name}" in columns for p in ("q", "qd") for name in self._joints)
        self._paths = MusclePaths(robot)

    def motion(self, rows: _Rows) -> tuple[FloatArray | None, FloatArray | None]:
        """Return rates of lengths and efforts, or None if q or qd is missing.

        Returns:
            Rates L qd, shape (K, m), in [m/s], and efforts -L^T f plus the torques of joint
            motors, shape (K, n), in [N·m] or [N].
        """
        if not self._has_qd:
            return None, None
        q, qd = rows.prefixed("q", self._joints), rows.prefixed("qd", self._joints)
        f = rows.first_available(("tension", "f"), self._muscles)
        rates, efforts = np.full_like(f, np.nan), np.full_like(q, np.nan)
        for k in np.flatnonzero(np.isfinite(q).all(axis=1)):
            L = self._paths.evaluate(q[k]).jacobian
            rates[k] = L @ qd[k]
            efforts[k] = -L.T @ f[k]
        efforts[:, self._motor_indices] += rows.first_available(
            (MEASURED_TORQUE, TORQUE), self._motors
        )
        return rates, efforts


def _units(robot: Robot) -> dict[str, str]:
    """Return the units of the commands and slack signals of a robot."""
    return {
        **{port.name: port.unit for port in command_ports(robot, "output", "discrete")},
        **slack_signals(robot, "joint"),
        **slack_signals(robot, "operational"),
    }
