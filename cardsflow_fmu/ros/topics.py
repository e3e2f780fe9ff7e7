"""The topics of a run: what its columns, and its robot where that is known, give as messages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.middleware import types
from cardsflow_fmu.middleware.cdr import Bytes, header, message_rows
from cardsflow_fmu.middleware.node import Topic
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.signals.hardware import MEASURED_TORQUE
from cardsflow_fmu.signals.muscles import command_ports
from cardsflow_fmu.signals.ports import (
    SOLVE_TIME,
    TORQUE,
    identifier,
    muscle_signals,
    slack_signals,
    task_signals,
    task_units,
)
from cardsflow_fmu.utils.arrays import FloatArray


class Batch(NamedTuple):
    """Messages of one topic.

    Attributes:
        topic: The topic.
        time_ns: When, shape (K,), in [ns].
        rows: Their bytes, shape (K, size).
    """

    topic: Topic
    time_ns: NDArray[np.int64]
    rows: Bytes


JOINT_STATES = Topic("/joint_states", types.JOINT_STATE)
JOINT_REFERENCE = Topic("/joint_reference", types.JOINT_STATE)
JOINT_COMMANDS = Topic("/joint_commands", types.JOINT_STATE)
TENDON_STATES = Topic("/tendon_states", types.TENDON_STATES)
TENDON_COMMANDS = Topic("/tendon_commands", types.TENDON_COMMANDS)
TASK_STATES = Topic("/task_states", types.TASK_STATES)
CONTROLLER_STATE = Topic("/controller_state", types.CONTROLLER_STATE)
SIGNALS = Topic("/signals", types.SIGNALS)

_FLAGS = ("infeasible", "not_converged", "limits_dropped")
_FORCES = ("f", "u", "tension")


_LATEST = 2.0**63 - 1024.0
"""The latest time that messages hold, in [ns]; later ones, and what is no time, are there."""


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
        robot: Its robot; None where that is not known: names are those of the columns then, and
            efforts and rates of lengths, which need it, are left out.
    """

    def __init__(self, run: RunData, robot: Robot | None = None) -> None:
        self._run, self._robot = run, robot
        self._units = (_units(robot) if robot is not None else {}) | dict(run.units)
        self._column = {name: k for k, name in enumerate(run.names)}
        joints = None if robot is None else [c.name for c in robot.coordinates]
        motors = None if robot is None else [c.name for c in robot.motors]
        muscles = None if robot is None else [muscle.name for muscle in robot.muscles]
        self._joints = self._names(("q",), joints)
        self._motors = self._names((TORQUE,), motors)
        self._muscles = self._names((*_FORCES, "l"), muscles)
        self._driven = self._names(_FORCES[:2], muscles)
        self._desired = self._names(("q_d",), joints)
        self._tasks = self._names(("y",), None)
        self._slack = self._names(("slack",), None)
        self._others = self._remaining()
        self._paths = _Paths(robot, self._column) if robot is not None else None
        nothing = _Rows(run, self._column, slice(0))
        self.topics = tuple(topic for topic, _ in self._values(nothing))

    def replace(self, run: RunData) -> None:
        """Take another run of the same columns."""
        self._run = run

    def batches(self, first: int, end: int) -> Iterator[Batch]:
        """The messages of the rows from `first` to before `end`."""
        table = _Rows(self._run, self._column, slice(first, end))
        head = {"header": header(table.time_ns)}
        for topic, values in self._values(table):
            rows = message_rows(topic.type, head | dict(values), len(table.time_ns))
            yield Batch(topic, table.time_ns, rows)

    def _values(self, table: _Rows) -> Iterator[tuple[Topic, Mapping[str, Any]]]:
        motion = self._paths.motion(table) if self._paths is not None else _Motion()
        if self._joints:
            yield (
                JOINT_STATES,
                {
                    **_named(self._joints),
                    "position": table.all("q", self._joints),
                    "velocity": table.known("qd", self._joints),
                    "effort": motion.efforts,
                },
            )
        if self._desired:
            yield (
                JOINT_REFERENCE,
                {
                    **_named(self._desired),
                    "position": table.all("q_d", self._desired),
                    "velocity": table.known("qd_d", self._desired),
                },
            )
        if self._motors:
            torques = table.all(TORQUE, self._motors)
            yield JOINT_COMMANDS, {**_named(self._motors), "effort": torques}
        if self._muscles:
            yield (
                TENDON_STATES,
                {
                    **_named(self._muscles),
                    "tension": table.first(("tension", "f"), self._muscles),
                    "length": table.all("l", self._muscles),
                    "velocity": table.all("l", {}) if motion.rates is None else motion.rates,
                },
            )
        if self._driven:
            commands = [self._unit(("u", "f"), name) for name in self._driven]
            yield (
                TENDON_COMMANDS,
                {
                    **_named(self._driven),
                    "unit": commands,
                    "command": table.first(("u", "f"), self._driven),
                    "tension": table.all("f", self._driven),
                },
            )
        if self._tasks:
            yield (
                TASK_STATES,
                {
                    **_named(self._tasks),
                    "unit": [self._unit(("y",), name) for name in self._tasks],
                    "position": table.all("y", self._tasks),
                    "desired": table.all("y_d", self._tasks),
                },
            )
        if self._slack or any(flag in self._column for flag in _FLAGS):
            yield (
                CONTROLLER_STATE,
                {
                    **{flag: table.flag(flag) for flag in _FLAGS},
                    "at_bound": table.one("at_bound"),
                    "solve_time": table.solve_times(),
                    **_named(self._slack),
                    "unit": [self._unit(("slack",), name) for name in self._slack],
                    "slack": table.all("slack", self._slack),
                },
            )
        if self._others:
            yield (
                SIGNALS,
                {
                    "name": self._others,
                    "unit": [self._units.get(name, "") for name in self._others],
                    "value": table.columns(self._others),
                },
            )

    def _names(self, prefixes: Sequence[str], names: Sequence[str] | None) -> dict[str, str]:
        """Names of what has a column of one of the prefixes, by how columns have them."""
        there = {
            name.partition(".")[2]: name.partition(".")[2]
            for name in self._column
            if name.partition(".")[0] in prefixes and "." in name
        }
        if names is None or not there:
            return there
        return {identifier(name): name for name in names}

    def _unit(self, prefixes: Sequence[str], name: str) -> str:
        units = [self._units.get(f"{prefix}.{name}") for prefix in prefixes]
        return next((unit for unit in units if unit is not None), "")

    def _remaining(self) -> list[str]:
        """Columns that no other topic has."""
        published = {"time", "at_bound", *_FLAGS}
        measured = (MEASURED_TORQUE,) if self._robot is not None else ()
        for prefixes, names in (
            (("q", "qd", *measured), self._joints),
            (("q_d", "qd_d"), self._desired),
            ((TORQUE,), self._motors),
            ((*_FORCES, "l"), self._muscles),
            (("y", "y_d"), self._tasks),
            (("slack",), self._slack),
        ):
            published |= {f"{prefix}.{name}" for prefix in prefixes for name in names}
        return [name for name in self._column if name not in published]


class _Rows:
    """Columns of some rows."""

    def __init__(self, run: RunData, column: Mapping[str, int], rows: slice) -> None:
        self._run, self._column = run, column
        self.values = run.rows[rows]
        self.time = self.values[:, column["time"]]
        self.time_ns = nanoseconds(self.time)

    def columns(self, names: Sequence[str]) -> FloatArray:
        """Columns by their whole names, NaN where there is none, shape (K, n)."""
        found = np.full((len(self.values), len(names)), np.nan)
        there = [k for k, name in enumerate(names) if name in self._column]
        found[:, there] = self.values[:, [self._column[names[k]] for k in there]]
        return found

    def all(self, prefix: str, names: Mapping[str, str]) -> FloatArray:
        """The columns of a prefix, NaN where there is none, shape (K, n)."""
        return self.columns([f"{prefix}.{name}" for name in names])

    def known(self, prefix: str, names: Mapping[str, str]) -> FloatArray | None:
        """The columns of a prefix; None where one is missing."""
        columns = [f"{prefix}.{name}" for name in names]
        return self.columns(columns) if set(columns) <= set(self._column) else None

    def first(self, prefixes: Sequence[str], names: Mapping[str, str]) -> FloatArray:
        """For each name the column of the first prefix that there is, shape (K, n)."""
        columns = [
            next((f"{p}.{name}" for p in prefixes if f"{p}.{name}" in self._column), "")
            for name in names
        ]
        return self.columns(columns)

    def one(self, name: str) -> FloatArray:
        """One column, NaN where there is none, shape (K,)."""
        return self.columns([name])[:, 0]

    def flag(self, name: str) -> NDArray[np.bool_]:
        """One column as truth values, shape (K,)."""
        values: NDArray[np.bool_] = np.nan_to_num(self.one(name)) != 0.0
        return values

    def solve_times(self) -> FloatArray:
        """How long each row's tick took, in [s]; NaN where there was none."""
        if SOLVE_TIME in self._column:
            return self.one(SOLVE_TIME)
        known = np.full(len(self.time), np.nan)
        ticks = self._run.solve_times
        if len(ticks) and len(known):
            at = np.searchsorted(nanoseconds(ticks[:, 0]), self.time_ns)
            at = np.minimum(at, len(ticks) - 1)
            same = nanoseconds(ticks[at, 0]) == self.time_ns
            known[same] = ticks[at[same], 1]
        return known


class _Motion(NamedTuple):
    """What follows from the robot.

    Attributes:
        rates: Of the muscles' lengths, shape (K, m), in [m/s]; None where they are not known.
        efforts: What muscles and motors make at the joints, shape (K, n), in [N·m] or [N].
    """

    rates: FloatArray | None = None
    efforts: FloatArray | None = None


class _Paths:
    """Muscle Jacobians along the motion."""

    def __init__(self, robot: Robot, column: Mapping[str, int]) -> None:
        from sim_dart import MusclePaths

        self._robot = robot
        self._joints = {identifier(c.name): c.name for c in robot.coordinates}
        self._muscles = {identifier(m.name): m.name for m in robot.muscles}
        self._motors = [robot.coordinates.index(motor) for motor in robot.motors]
        self._known = all(f"{p}.{name}" in column for p in ("q", "qd") for name in self._joints)
        self._paths = MusclePaths(robot)

    def motion(self, table: _Rows) -> _Motion:
        """What follows from q, qd and the tensions: l' = L q', effort = -L' f + torques."""
        if not self._known:
            return _Motion()
        q, qd = table.all("q", self._joints), table.all("qd", self._joints)
        f = table.first(("tension", "f"), self._muscles)
        rates, efforts = np.full_like(f, np.nan), np.full_like(q, np.nan)
        for k in np.flatnonzero(np.isfinite(q).all(axis=1)):
            L = self._paths.evaluate(q[k]).jacobian
            rates[k] = L @ qd[k]
            efforts[k] = -L.T @ f[k]
        motors = {identifier(motor.name): motor.name for motor in self._robot.motors}
        torques = table.first((MEASURED_TORQUE, TORQUE), motors)
        efforts[:, self._motors] += torques
        return _Motion(rates, efforts)


def _units(robot: Robot) -> dict[str, str]:
    """The units of a robot's commands, tasks and slack."""
    return {
        **dict.fromkeys(muscle_signals("f", robot), "N"),
        **{port.name: port.unit for port in command_ports(robot, "output", "discrete")},
        **dict(zip(task_signals("y", robot), task_units(robot), strict=True)),
        **slack_signals(robot, "joint"),
        **slack_signals(robot, "operational"),
    }


def _named(names: Mapping[str, str]) -> Mapping[str, Any]:
    return {"name": list(names.values())}
