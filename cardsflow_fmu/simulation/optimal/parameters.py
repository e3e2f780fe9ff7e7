"""Free parameters of a motion: robots with other values, and found values by path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, check
from cardsflow_fmu.experiment.config.key_path import split_path
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.motion.parameters import ParameterSettings
from cardsflow_fmu.experiment.robot_overrides import KINDS, with_overrides
from cardsflow_fmu.simulation.nominal_values import nominal_value
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.optimal.problem import Parameters
from sim_dart.optimal.parameters import RobotFamily
from sim_dart.optimal.shooting import Shooting

_SUPPORTED = (
    *("point_position", "surface_", "pulley_", "condition_", "branch_divisor", "law_parameter"),
    *("mass", "inertia", "damping", "armature", "stiffness", "rest", "limit_numbers", "piece"),
)
"""First letters of the fields of the core that parameters may change."""
_AT_BOUND = 1e-6  # distance from a bound, relative to the range
_KINDS = (
    "via points, wrap surfaces and laws of muscles, masses and inertias of links, and springs, "
    "damping and armatures of joints"
)


@dataclass(frozen=True)
class FreeParameters:
    """Free parameters of an experiment: the elements of vectors that may change.

    Attributes:
        experiment: An experiment with [motion].
        robot: Robot of the motion.
        paths: Keys of the numbers and vectors.
        values: Their values in the robot, with those of constant elements, by path.
        elements: Index of the path, and of the element in its vector, for each parameter.
        parameters: Bounds, values and weights for the optimisation.
    """

    experiment: Experiment
    robot: Robot
    paths: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    elements: tuple[tuple[int, int], ...]
    parameters: Parameters

    @property
    def family(self) -> RobotFamily:
        """The robots."""
        parameters = self.parameters
        return RobotFamily(self.robot_at, parameters.low, parameters.high, parameters.nominal)

    def settings(self, p: FloatArray) -> dict[str, float | list[float]]:
        """Return the numbers and vectors by path, for values p, shape (np,)."""
        rows = [list(row) for row in self.values]
        for (k, element), value in zip(self.elements, p.tolist(), strict=True):
            rows[k][element] = value
        values = [row if len(row) > 1 else row[0] for row in rows]
        return dict(zip(self.paths, values, strict=True))

    def lines(self, p: FloatArray) -> list[str]:
        """Return a line about each parameter: value before and after, and active bounds."""
        parameters, lines = self.parameters, []
        near = _AT_BOUND * (parameters.high - parameters.low)
        for k, name in enumerate(parameters.names):
            at = "at the largest value" if p[k] >= parameters.high[k] - near[k] else ""
            at = "at the smallest value" if p[k] <= parameters.low[k] + near[k] else at
            line = f"{name}: {parameters.nominal[k]:.6g} -> {p[k]:.6g}"
            lines.append(f"{line} ({at})" if at else line)
        return lines

    def robot_at(self, p: FloatArray) -> Robot:
        """Return the robot with values p, shape (np,)."""
        robot = self.robot
        for path, value in self.settings(p).items():
            robot = with_overrides(robot, _changes(path, value), self.experiment.file, "robot")
        return robot

    def require_valid(self) -> None:
        """Check the robots with each parameter at its bounds."""
        parameters = self.parameters
        for k, (table, _) in enumerate(self.elements):
            for bound in (parameters.low[k], parameters.high[k]):
                p = parameters.nominal.copy()
                p[k] = bound
                wrong = next((one for one in check(self.robot_at(p)) if one.is_error), None)
                if wrong is not None:
                    problem = f"{parameters.names[k]} = {bound:.6g}: {wrong}".replace("error: ", "")
                    raise InputError(problem, file=self.experiment.file, key=_key(table))

    def require_effect(self, shooting: Shooting) -> None:
        """Check that each parameter changes the motion, and only what is supported."""
        motion, names = self.experiment.motion, self.parameters.names
        assert motion is not None
        rows = zip(self.elements, names, shooting.changed_fields(), strict=True)
        for (k, _), name, fields in rows:
            wrong = [field for field in fields if not field.startswith(_SUPPORTED)]
            if "point_position" in fields and any(each.cables for each in motion.obstacles):
                problem = f"{name} moves cables; not supported with cables in motion.obstacles"
                raise InputError(problem, file=self.experiment.file, key=_key(k))
            if fields and not wrong:
                continue
            problem = f"{name} has no effect on the motion; use {_KINDS}"
            if wrong:
                problem = f"{name} changes the kinematics, which is not supported; use {_KINDS}"
            elif ".model." in name and motion.muscles == "forces":
                problem = f'{name} has no effect on the motion; set motion.muscles = "laws"'
            raise InputError(problem, file=self.experiment.file, key=_key(k))


def free_parameters(experiment: Experiment, robot: Robot) -> FreeParameters | None:
    """Return the free parameters of an experiment; None if it has none.

    Args:
        experiment: An experiment with [motion].
        robot: Robot of the motion.

    Raises:
        InputError: A parameter is invalid; the message names its key.
    """
    assert experiment.motion is not None
    tables = experiment.motion.parameters
    if not tables:
        return None
    paths = tuple(table.path for table in tables)
    for k, path in enumerate(paths):
        if path in paths[:k]:
            raise InputError(f"duplicate path {path!r}", file=experiment.file, key=_key(k))
    values = tuple(_value(experiment, robot, k, table) for k, table in enumerate(tables))
    elements = tuple(
        (k, i)
        for k, table in enumerate(tables)
        for i, (low, high) in enumerate(zip(table.low, table.high, strict=True))
        if low < high
    )
    parameters = Parameters(
        np.array([tables[k].low[i] for k, i in elements]),
        np.array([tables[k].high[i] for k, i in elements]),
        np.array([values[k][i] for k, i in elements]),
        np.array([tables[k].weight for k, _ in elements]),
        tuple(_name(tables[k], i) for k, i in elements),
    )
    free = FreeParameters(experiment, robot, paths, values, elements, parameters)
    free.require_valid()
    return free


def _key(k: int) -> str:
    return f"motion.parameters[{k}]"


def _name(table: ParameterSettings, element: int) -> str:
    size = len(table.low)
    if size == 1:
        return table.path
    return f"{table.path}.{'xyz'[element]}" if size == 3 else f"{table.path}[{element}]"


def _changes(path: str, value: Any) -> dict[str, Any]:
    """Return the nested tables below [robot] that set a value."""
    for name in reversed(split_path(path)[1:]):
        value = {name: value}
    changes: dict[str, Any] = value
    return changes


def _value(
    experiment: Experiment, robot: Robot, k: int, table: ParameterSettings
) -> tuple[float, ...]:
    """Return the elements of the number or vector at the path of a table."""
    key = _key(k)
    try:
        parts = split_path(table.path)
        if len(parts) < 4 or parts[0] != "robot" or parts[1] not in KINDS:
            problem = "must begin with " + ", ".join(f"robot.{kind}" for kind in KINDS)
            raise InputError(f"{problem}, and name a part and its number, not {table.path!r}")
        bound = table.low if len(table.low) > 1 else table.low[0]
        changes = _changes(table.path, list(bound) if isinstance(bound, tuple) else bound)
        with_overrides(robot, changes, experiment.file, "robot")
        nominal = nominal_value(experiment, table.path)
    except InputError as error:
        error.file, error.key = experiment.file, f"{key}.path"
        raise
    values = nominal if isinstance(nominal, tuple) else (nominal,)
    for low, value, high in zip(table.low, values, table.high, strict=True):
        if low < high and not low <= value <= high:
            problem = f"must contain the value of the robot, {value!r}, not {low!r} to {high!r}"
            raise InputError(problem, file=experiment.file, key=f"{key}.from")
    return tuple(
        value if low < high else low
        for low, value, high in zip(table.low, values, table.high, strict=True)
    )
