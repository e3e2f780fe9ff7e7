"""Nominal values of settings, to which relative variations are applied."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Any

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.experiment.config.key_path import split_index, split_path
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.robot_overrides import ALIASES, KINDS, is_parameters
from cardsflow_fmu.experiment.settings.hardware import hardware_data
from cardsflow_fmu.experiment.writer import experiment_data

Nominal = float | tuple[float, ...]


def nominal_value(experiment: Experiment, path: str) -> Nominal:
    """Return the number or vector at a path.

    Raises:
        InputError: The setting is not a finite real number or vector.
    """
    value: Any = _tables(experiment)
    for part in split_path(path):
        value = _inner(value, part, experiment)
    if isinstance(value, list | tuple) and value and all(_is_real(x) for x in value):
        return tuple(value)
    if _is_real(value):
        return float(value)
    raise InputError(f"{path} is {_describe(value)}; remove `relative`")


def _describe(value: Any) -> str:
    if value is None:
        return "not set"
    if isinstance(value, int) and not isinstance(value, bool):
        return f"the integer {value}, not a real number"
    return f"{value!r}, not a real number"


def _is_real(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _tables(experiment: Experiment) -> dict[str, Any]:
    """Return the experiment as nested tables, including its robot."""
    robot = experiment.robot
    parts = {kind: {item.name: item for item in getattr(robot, kind)} for kind in KINDS}
    data = experiment_data(experiment)
    return data | {
        "robot": data.get("robot", {}) | parts,
        "hardware": hardware_data(experiment.hardware, robot),
    }


def _inner(value: Any, part: str, experiment: Experiment) -> Any:
    """Return the element of a value for one part of a path, or None."""
    name, index = split_index(part)
    element: Any
    if dataclasses.is_dataclass(value):
        element = getattr(value, ALIASES.get(name, name), None)
    elif is_parameters(value):
        element = dict(value).get(name)
    elif isinstance(value, dict):
        if part in value:
            return value[part]
        element = value.get(name)
    elif isinstance(value, list | tuple):
        return next((v for names, v in _by_name(value, experiment) if names == part), None)
    else:
        return None
    if index is None:
        return element
    fits = isinstance(element, list | tuple) and index < len(element)
    return element[index] if fits else None


def _by_name(row: Sequence[Any], experiment: Experiment) -> Iterator[tuple[str, Any]]:
    """Yield the elements of a row by name, for all kinds of names with the length of the row."""
    robot = experiment.robot
    for names in (
        [c.name for c in robot.coordinates],
        list(task_names(robot)),
        [muscle.name for muscle in robot.muscles],
        [link.name for link in robot.links],
    ):
        if len(names) == len(row):
            yield from zip(names, row, strict=True)
