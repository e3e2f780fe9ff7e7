"""The topics of a run with a message a row: its columns as joint states and signals."""

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
"""Signal with the time that a tick of the controller took, where the run measured it."""
_LATEST = 2.0**63 - 1024.0
"""The latest time that messages hold, in [ns]; later ones, and invalid ones, are clipped to it."""


class Batch(NamedTuple):
    """Messages of one topic that differ in their numbers alone.

    Attributes:
        topic: The topic.
        time_ns: Times of K messages, shape (K,), in [ns].
        values: Their fields; every array has K rows, all else is the same in all messages. An array
            of shape (K, n, 3) is n points.
    """

    topic: Topic
    time_ns: NDArray[np.int64]
    values: Values


def nanoseconds(time: FloatArray) -> NDArray[np.int64]:
    """Times in [s] as whole [ns]."""
    with np.errstate(over="ignore"):
        whole = np.nan_to_num(np.rint(1e9 * time), nan=_LATEST)
    times: NDArray[np.int64] = np.clip(whole, -_LATEST, _LATEST).astype(np.int64)
    return times


class RowTopics:
    """The topics with a message a row.

    Args:
        run: The run.
        robot: Its robot; None if that is not known: names are those of the columns then, and
            efforts and rates of lengths, which need it, are left out.
    """

    def __init__(self, run: RunData, robot: Robot | None = None) -> None:
        self._run, self._robot = run, robot
        known = _units(robot) if robot is not None else {}
        self._units = known | {_TICK_TIME: "s"} | dict(run.units)
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
        self._paths = _Paths(robot, self._columns) if robot is not None else None
        tables = self._tables(_Rows(run, self._columns, slice(0)))
        self.topics = (*(table.topic for table in tables), *([SIGNALS] if self._signals else []))

    def replace(self, run: RunData) -> None:
        """Take another run of the same columns."""
        self._run = run

    def batches(self, first: int, end: int) -> Iterator[Batch]:
        """The messages of the rows from `first` to before `end`, topic by topic."""
        rows = _Rows(self._run, self._columns, slice(first, end))
        times = nanoseconds(rows.time)
        for table in self._tables(rows):
            yield table.batch(times)
        if self._signals:
            yield self._signal_batch(rows, times)

    def _signal_batch(self, rows: _Rows, time_ns: NDArray[np.int64]) -> Batch:
        """Return the columns that no topic of joint states has, and the times of ticks."""
        names, values = list(self._signals), rows.columns(self._signals)
        ticks = None if SOLVE_TIME in self._columns else rows.tick_times()
        if ticks is not None:
            names, values = [*names, _TICK_TIME], np.column_stack([values, ticks])
        units = [self._units.get(name, "") for name in names]
        fields = {"header": header(time_ns), "name": names, "unit": units, "value": values}
        return Batch(SIGNALS, time_ns, fields)

    def _tables(self, rows: _Rows) -> list[_Table]:
        """The topics of joint states; a tendon is a joint of position l, velocity l', effort f."""
        rates, efforts = self._paths.motion(rows) if self._paths is not None else (None, None)
        tables = [
            _Table(
                JOINT_STATES,
                self._joints,
                rows.all("q", self._joints),
                rows.known("qd", self._joints),
                efforts,
            ),
            _Table(
                JOINT_REFERENCE,
                self._desired,
                rows.all("q_d", self._desired),
                rows.known("qd_d", self._desired),
            ),
            _Table(JOINT_COMMANDS, self._motors, effort=rows.all(TORQUE, self._motors)),
            _Table(
                TENDON_STATES,
                self._muscles,
                rows.all("l", self._muscles),
                rates,
                rows.first(("tension", "f"), self._muscles),
            ),
            _Table(TENDON_COMMANDS, self._driven, effort=rows.all("f", self._driven)),
            _Table(TASK_STATES, self._tasks, rows.all("y", self._tasks)),
            _Table(TASK_REFERENCE, self._task_references, rows.all("y_d", self._task_references)),
        ]
        return [table for table in tables if table.names]

    def _names(self, prefixes: Sequence[str], names: Sequence[str] | None) -> dict[str, str]:
        """Return names of what has a column of one of the prefixes, by how columns have them."""
        there = {
            name.partition(".")[2]: name.partition(".")[2]
            for name in self._columns
            if name.partition(".")[0] in prefixes and "." in name
        }
        if names is None or not there:
            return there
        return {identifier(name): name for name in names}

    def _other_columns(self) -> list[str]:
        """Return columns that no topic of joint states has."""
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
    """Joint states of one topic, a message a row.

    Attributes:
        topic: The topic.
        names: Names of the joints, by how columns have them.
        position, velocity, effort: Shape (K, n) each; None if they are left out.
    """

    topic: Topic
    names: Mapping[str, str]
    position: FloatArray | None = None
    velocity: FloatArray | None = None
    effort: FloatArray | None = None

    def batch(self, time_ns: NDArray[np.int64]) -> Batch:
        """Return the messages, at times of shape (K,), in [ns]."""
        fields = {"position": self.position, "velocity": self.velocity, "effort": self.effort}
        known = {field: table for field, table in fields.items() if table is not None}
        names = tuple(self.names.values())
        return Batch(self.topic, time_ns, {"header": header(time_ns), "name": names, **known})


class _Rows:
    """Columns of some rows."""

    def __init__(self, run: RunData, places: Mapping[str, int], rows: slice) -> None:
        self._run, self._places = run, places
        self._values = run.rows[rows]
        self.time = self._values[:, places["time"]]

    def columns(self, names: Sequence[str]) -> FloatArray:
        """Return columns by their whole names, NaN if there is none, shape (K, n)."""
        found = np.full((len(self._values), len(names)), np.nan)
        there = [k for k, name in enumerate(names) if name in self._places]
        found[:, there] = self._values[:, [self._places[names[k]] for k in there]]
        return found

    def all(self, prefix: str, names: Mapping[str, str]) -> FloatArray:
        """Return the columns of a prefix, NaN if there is none, shape (K, n)."""
        return self.columns([f"{prefix}.{name}" for name in names])

    def known(self, prefix: str, names: Mapping[str, str]) -> FloatArray | None:
        """Return the columns of a prefix; None if one is missing."""
        columns = [f"{prefix}.{name}" for name in names]
        return self.columns(columns) if set(columns) <= set(self._places) else None

    def first(self, prefixes: Sequence[str], names: Mapping[str, str]) -> FloatArray:
        """For each name the column of the first prefix that there is, shape (K, n)."""
        columns = [
            next((f"{p}.{name}" for p in prefixes if f"{p}.{name}" in self._places), "")
            for name in names
        ]
        return self.columns(columns)

    def tick_times(self) -> FloatArray | None:
        """How long each row's tick took, NaN if there was none, in [s]; None if not measured."""
        ticks = self._run.solve_times
        if not len(ticks) or not len(self.time):
            return None
        known = np.full(len(self.time), np.nan)
        times, own = nanoseconds(ticks[:, 0]), nanoseconds(self.time)
        at = np.minimum(np.searchsorted(times, own), len(ticks) - 1)
        known[times[at] == own] = ticks[at[times[at] == own], 1]
        return known


class _Paths:
    """Muscle Jacobians along the motion."""

    def __init__(self, robot: Robot, columns: Mapping[str, int]) -> None:
        from sim_dart import MusclePaths

        self._joints = {identifier(c.name): c.name for c in robot.coordinates}
        self._muscles = {identifier(m.name): m.name for m in robot.muscles}
        self._motors = {identifier(motor.name): motor.name for motor in robot.motors}
        self._motor_places = [robot.coordinates.index(motor) for motor in robot.motors]
        self._known = all(f"{p}.{name}" in columns for p in ("q", "qd") for name in self._joints)
        self._paths = MusclePaths(robot)

    def motion(self, rows: _Rows) -> tuple[FloatArray | None, FloatArray | None]:
        """Rates of lengths l' = L q' and efforts -L' f + torques; None if q or q' is missing.

        Returns:
            Shape (K, m), in [m/s], and shape (K, n), in [N·m] or [N].
        """
        if not self._known:
            return None, None
        q, qd = rows.all("q", self._joints), rows.all("qd", self._joints)
        f = rows.first(("tension", "f"), self._muscles)
        rates, efforts = np.full_like(f, np.nan), np.full_like(q, np.nan)
        for k in np.flatnonzero(np.isfinite(q).all(axis=1)):
            L = self._paths.evaluate(q[k]).jacobian
            rates[k] = L @ qd[k]
            efforts[k] = -L.T @ f[k]
        efforts[:, self._motor_places] += rows.first((MEASURED_TORQUE, TORQUE), self._motors)
        return rates, efforts


def _units(robot: Robot) -> dict[str, str]:
    """Return the units of a robot's commands and slack."""
    return {
        **{port.name: port.unit for port in command_ports(robot, "output", "discrete")},
        **slack_signals(robot, "joint"),
        **slack_signals(robot, "operational"),
    }
