"""Feed-forward and feedback gains along an optimal motion: `motion.gains.csv`."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError, limits
from cardsflow_fmu.cosim.signals.muscles import command_signals, state_ports
from cardsflow_fmu.cosim.signals.port import coordinate_signals, motor_signals, muscle_signals
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import read_csv, require_table

_GAIN = "K."


@dataclass(frozen=True)
class MotionFeedback:
    """Control u = u* + K (x* - x), held from the time of each row to the next one.

    Attributes:
        times: Times of the rows, increasing from 0, shape (k,), in [s]. The last row holds the
            robot after the motion.
        forces: Muscle forces and motor torques f*, shape (k, a), in [N] and [N·m].
        controls: u*, shape (k, nu): commands of driven muscles, and torques of motors.
        states: x* at the times of the rows: q, qd and states of muscles, shape (k, nx).
        gains: K, shape (k, nu, nx).
        control_names: Names of the controls: `f.<muscle>`, or `u.<muscle>` for commands of muscle
            laws, then `tau.<coordinate>`.
        state_names: Names of the states: `q.<coordinate>`, `qd.<coordinate>`, states of muscles.
    """

    times: FloatArray
    forces: FloatArray
    controls: FloatArray
    states: FloatArray
    gains: FloatArray
    control_names: tuple[str, ...]
    state_names: tuple[str, ...]

    @property
    def has_commands(self) -> bool:
        """Whether the controls of muscles with muscle laws are their commands."""
        return any(name.startswith("u.") for name in self.control_names)

    def columns(self, force_names: Sequence[str]) -> dict[str, FloatArray]:
        """Return the columns of the file by name."""
        columns = {"time": self.times}
        columns |= dict(zip(force_names, self.forces.T, strict=True))
        columns |= dict(zip(self.control_names, self.controls.T, strict=True))
        columns |= dict(zip(self.state_names, self.states.T, strict=True))
        names = _gain_names(self.control_names, self.state_names)
        return columns | dict(zip(names, self.gains.reshape(len(self.times), -1).T, strict=True))


def gains_file(motion: Path) -> Path:
    """Return the file of the gains of a motion, `motion.gains.csv` for `motion.csv`."""
    return motion.with_suffix(".gains.csv")


def force_names(robot: Robot) -> list[str]:
    """Return the names of the muscle forces and motor torques of a robot."""
    return [*muscle_signals("f", robot), *motor_signals("tau", robot)]


def _gain_names(controls: Sequence[str], states: Sequence[str]) -> list[str]:
    return [f"{_GAIN}{control}.{state}" for control in controls for state in states]


def read_feedback(file: Path, robot: Robot, experiment: Path) -> MotionFeedback:
    """Read the feedback along a motion.

    Args:
        file: The file that `cardsflow optimise` writes.
        experiment: File of the experiment, for messages.

    Raises:
        InputError: The file does not exist, or is not a feedback of this robot.
    """
    again = f"compute it: `cardsflow optimise {shlex.quote(str(experiment))}`"
    if not file.is_file():
        raise InputError(f"{file} does not exist; {again}")
    try:
        names, rows = read_csv(file, kind="table of gains", most=limits.MOTION_VALUES)
        require_table(names, rows, None, kind="table of gains")
        return _feedback(dict(zip(names, rows.T, strict=True)), robot)
    except InputError as error:
        error.problem = f"{file.name}: {error.problem}; {again}"
        raise


def _feedback(columns: dict[str, FloatArray], robot: Robot) -> MotionFeedback:
    present = [name for name in columns if name.startswith(_GAIN)]
    if not present:
        raise InputError("has no gains K")
    of_coordinates = [*coordinate_signals("q", robot), *coordinate_signals("qd", robot)]
    of_muscles = [port.name for port in state_ports(robot, "input")]
    commands = [name for name in command_signals(robot) if name in columns]
    replaced = {f"f.{name.removeprefix('u.')}" for name in commands}
    states = (*of_coordinates, *(of_muscles if commands else ()))
    named = [*commands, *(name for name in force_names(robot) if name not in replaced)]
    controls = tuple(
        name for name in named if any(gain in columns for gain in _gain_names([name], states))
    )
    gains = _gain_names(controls, states)
    if unknown := sorted(set(present) - set(gains)):
        raise UnknownNameError("gain", unknown[0].removeprefix(_GAIN), _expected(named, states))
    needed = ["time", *force_names(robot), *controls, *states, *gains]
    for name in needed:
        if name not in columns:
            raise InputError(f"has no column {name!r}")
        if (wrong := ~np.isfinite(columns[name])).any():
            raise InputError(f"{name!r} must be finite, which row {wrong.argmax() + 1} is not")
    times = columns["time"]
    if len(times) < 2 or times[0] != 0.0 or (np.diff(times) <= 0.0).any():
        raise InputError("must have at least 2 rows, whose times increase from 0")

    def table(names: Sequence[str]) -> FloatArray:
        return np.stack([columns[name] for name in names], axis=1)

    shape = len(times), len(controls), len(states)
    of_gains = table(gains).reshape(shape)
    forces = table(force_names(robot))
    return MotionFeedback(times, forces, table(controls), table(states), of_gains, controls, states)


def _expected(controls: Sequence[str], states: Sequence[str]) -> list[str]:
    return [f"{control}.{state}" for control in controls for state in states]


def require_same_motion(
    feedback: MotionFeedback, period: float, first: FloatArray | None, duration: float | None
) -> None:
    """Check that a feedback belongs to a motion and to the period of a controller.

    Args:
        period: Period of the controller, in [s].
        first: First joint positions of the motion; None if it is not in joint space.
        duration: Duration of the motion, in [s]; None if it is unknown.

    Raises:
        InputError: It does not.
    """
    shortest = float(np.diff(feedback.times).min())
    if period > shortest * (1.0 + 1e-6):
        problem = f"its gains are for intervals of {shortest:.4g} s, shorter than controller.period"
        raise InputError(f"{problem}, {period:.4g} s; optimise with this controller.period")
    start = feedback.states[0]
    is_other = first is not None and not np.allclose(start[: len(first)], first, atol=1e-3)
    end = float(feedback.times[-1])
    if is_other or (duration is not None and abs(end - duration) > 1e-6 * max(end, 1.0)):
        raise InputError("its gains belong to another motion than [reference]; optimise again")
