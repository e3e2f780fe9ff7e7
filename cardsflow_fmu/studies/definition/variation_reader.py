"""The reader of [[vary]]: paths, and `*` for all names."""

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

from .nominal_values import nominal_value
from .outcome import LEADING_COLUMNS, TRAILING_COLUMNS
from .path_check import PathCheck
from .tables import VarySettings
from .variations import Relative, Variation


def read_variations(
    tables: Sequence[VarySettings], check: PathCheck, context: Context
) -> list[Variation]:
    """Return the variations of a study."""
    found: list[Variation] = []
    for k, table in enumerate(tables):
        with context.at(f"vary[{k}].path"):
            found += _variations(table, check)
    paths = [path for variation in found for path in variation.paths]
    for kind, words in (("name", [variation.name for variation in found]), ("path", paths)):
        twice = [word for word in words if words.count(word) > 1]
        if twice:
            raise context.error("vary", f"the {kind} {twice[0]!r} is there twice")
    _require_order(paths, context)
    return found


def require_free_names(
    variations: Sequence[Variation], metrics: Sequence[str], context: Context
) -> None:
    """Reject variations that are called as another column of the table is."""
    for variation in variations:
        if variation.name in (*LEADING_COLUMNS, *TRAILING_COLUMNS, *metrics):
            what = f"the table has another column {variation.name!r}; give the variation a name"
            raise context.error("vary", what)


def _require_order(paths: Sequence[str], context: Context) -> None:
    """Reject a path below which another before it has set something that it would undo."""
    before: set[str] = set()
    for path in paths:
        if path in before:
            what = f"{path!r} undoes what is before it for a part of it; let it be first"
            raise context.error("vary", what)
        parts = split_path(path)
        before |= {join_path(parts[:k]) for k in range(1, len(parts))}
        name, index = split_index(parts[-1])
        if index is not None:
            before.add(join_path([*parts[:-1], name]))


def _variations(table: VarySettings, check: PathCheck) -> Iterator[Variation]:
    name = table.name or table.paths[0]
    for axis, values in table.ranges():
        one = Variation(f"{name}{axis}", tuple(f"{path}{axis}" for path in table.paths), values)
        for own in _expand_wildcards(one, table.together, check):
            yield own if table.relative is None else _related(own, table.relative, check)


def _related(variation: Variation, relative: Relative, check: PathCheck) -> Variation:
    """Return the variation with what the experiment has at its paths."""
    nominal = tuple(nominal_value(check.base, path) for path in variation.paths)
    for path, value in zip(variation.paths, nominal, strict=True):
        if relative == "factor" and not np.any(value):
            raise InputError(f"{path} is 0, and so is every factor of it; use relative = 'offset'")
        if relative == "offset" and isinstance(value, tuple):
            raise InputError(f"{path} is a vector; say which number, such as {path}[0], or a box")
    return replace(variation, relative=relative, nominal=nominal)


def _expand_wildcards(
    variation: Variation, together: bool, check: PathCheck
) -> Iterator[Variation]:
    """The variation with the names that `*` matches, checked on the experiment."""
    value = variation.range.at(0.5)
    paths = [_names(path, value, check) for path in variation.paths]
    if together:
        everything = tuple(path for several in paths for path in several)
        yield Variation(variation.name, everything, variation.range)
        return
    if len({len(several) for several in paths}) > 1:
        raise InputError("with `*` the paths match different numbers of names")
    for same in zip(*paths, strict=True):
        name = variation.name if len(paths[0]) == 1 else same[0]
        yield Variation(name, tuple(same), variation.range)


def _names(path: str, value: Any, check: PathCheck) -> list[str]:
    """Return a path, or those that it matches."""
    parts = split_path(path)
    if EVERY_OTHER not in parts:
        check.require(path, value)
        return [path]
    k = parts.index(EVERY_OTHER)
    trouble: list[UnknownNameError] = []
    for names in _candidates(check.base):
        spelled = [join_path([*parts[:k], name, *parts[k + 1 :]]) for name in names]
        try:
            return [inner for one in spelled for inner in _names(one, value, check)]
        except UnknownNameError as error:
            trouble.append(error)
    raise max(trouble, key=lambda error: len((error.key or "").split(".")))  # got the farthest


def _candidates(experiment: Experiment) -> Iterator[Sequence[str]]:
    """The lists of names that `*` may match."""
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
