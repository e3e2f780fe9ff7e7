"""Reader for [[vary]]: paths with `*` for all names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from cardsflow_fmu.cosim.signals.ports import task_names
from cardsflow_fmu.experiment.config.key_path import EVERY_OTHER, join_path, split_index, split_path
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.simulation.nominal_values import nominal_value

from .outcome import LEADING_COLUMNS, TRAILING_COLUMNS
from .path_check import PathCheck
from .tables import VarySettings
from .variations import Relative, Variation


def read_variations(
    tables: Sequence[VarySettings], check: PathCheck, context: Context
) -> list[Variation]:
    """Return the variations of a study."""
    variations: list[Variation] = []
    for k, table in enumerate(tables):
        with context.at(f"vary[{k}].path"):
            variations += _variations(table, check)
    paths = [path for variation in variations for path in variation.paths]
    for kind, names in (("name", [variation.name for variation in variations]), ("path", paths)):
        duplicates = [name for name in names if names.count(name) > 1]
        if duplicates:
            raise context.error("vary", f"duplicate {kind} {duplicates[0]!r}; remove one")
    _require_order(paths, context)
    return variations


def require_unique_columns(
    variations: Sequence[Variation], metrics: Sequence[str], context: Context
) -> None:
    """Reject variations with the name of another column of the table."""
    for variation in variations:
        if variation.name in (*LEADING_COLUMNS, *TRAILING_COLUMNS, *metrics):
            problem = f"the table has another column {variation.name!r}; rename the variation"
            raise context.error("vary", problem)


def _require_order(paths: Sequence[str], context: Context) -> None:
    """Reject a path that would overwrite an earlier variation of one of its parts."""
    before: set[str] = set()
    for path in paths:
        if path in before:
            problem = f"{path!r} overwrites an earlier variation of a part of it; list it first"
            raise context.error("vary", problem)
        parts = split_path(path)
        before |= {join_path(parts[:k]) for k in range(1, len(parts))}
        name, index = split_index(parts[-1])
        if index is not None:
            before.add(join_path([*parts[:-1], name]))


def _variations(table: VarySettings, check: PathCheck) -> Iterator[Variation]:
    name = table.name or table.paths[0]
    for axis, values in table.ranges():
        paths = tuple(f"{path}{axis}" for path in table.paths)
        unexpanded = Variation(f"{name}{axis}", paths, values)
        for variation in _expand_wildcards(unexpanded, table.together, check):
            if table.relative is None:
                yield variation
            else:
                yield _relative_variation(variation, table.relative, check)


def _relative_variation(variation: Variation, relative: Relative, check: PathCheck) -> Variation:
    """Return a relative variation with the nominal values at its paths."""
    nominal = tuple(nominal_value(check.base, path) for path in variation.paths)
    for path, value in zip(variation.paths, nominal, strict=True):
        if relative == "factor" and not np.any(value):
            raise InputError(f"{path} is 0, so a factor has no effect; use relative = 'offset'")
        if relative == "offset" and isinstance(value, tuple):
            raise InputError(f"{path} is a vector; use one element, such as {path}[0], or a box")
    return replace(variation, relative=relative, nominal=nominal)


def _expand_wildcards(
    variation: Variation, together: bool, check: PathCheck
) -> Iterator[Variation]:
    """Yield the variations for all names that `*` matches, after a check of their paths."""
    value = variation.range.at(0.5)
    matches = [_matching_paths(path, value, check) for path in variation.paths]
    if together:
        paths = tuple(path for group in matches for path in group)
        yield Variation(variation.name, paths, variation.range)
        return
    if len({len(group) for group in matches}) > 1:
        raise InputError("`*` matches different numbers of names in the paths")
    for row in zip(*matches, strict=True):
        name = variation.name if len(matches[0]) == 1 else row[0]
        yield Variation(name, tuple(row), variation.range)


def _matching_paths(path: str, value: Any, check: PathCheck) -> list[str]:
    """Return all paths that a path with `*` matches, or the path itself."""
    parts = split_path(path)
    if EVERY_OTHER not in parts:
        check.require(path, value)
        return [path]
    k = parts.index(EVERY_OTHER)
    errors: list[UnknownNameError] = []
    for names in _candidates(check.base):
        paths = [join_path([*parts[:k], name, *parts[k + 1 :]]) for name in names]
        try:
            return [match for path in paths for match in _matching_paths(path, value, check)]
        except UnknownNameError as error:
            errors.append(error)
    raise max(errors, key=lambda error: len((error.key or "").split(".")))  # the deepest key


def _candidates(experiment: Experiment) -> Iterator[Sequence[str]]:
    """Yield the lists of names that `*` can match."""
    robot: Robot = experiment.robot
    yield from (
        names
        for names in (
            [muscle.name for muscle in robot.muscles],
            [link.name for link in robot.links],
            [c.name for c in robot.coordinates],
            list(task_names(robot)),
            [joint.name for joint in robot.joints],
            [frame.name for frame in robot.task_frames],
            [surface.name for surface in robot.wrap_surfaces],
        )
        if names
    )
