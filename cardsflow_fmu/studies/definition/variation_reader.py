"""Reading [[vary]]: paths, `*` for all names, and one of the ways to give values."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from cardsflow_fmu.config.key_path import EVERY_OTHER, indexed, join_path, split_path
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.ports import task_names

from .nominal_values import nominal_value
from .outcome import LEADING_COLUMNS, TRAILING_COLUMNS
from .path_check import Trial
from .variations import (
    RELATIVE,
    Listed,
    LogUniform,
    Normal,
    Range,
    Relative,
    Seed,
    Uniform,
    Variation,
)

_WAYS = ("values", "grid", "uniform", "loguniform", "normal", "box", "seed")
_MOST_VALUES = 1_000_000


def read_variations(table: Table, rows: Sequence[Any], trial: Trial) -> list[Variation]:
    """The variations of a study.

    Args:
        table: The study.
        rows: Its array of tables `vary`.
        trial: The experiment, to try paths on.

    Raises:
        InputError: A way to give values is wrong.
        UnknownNameError: A path leads nowhere; the nearest is named.
    """
    found: list[Variation] = []
    for k, row in enumerate(rows):
        if not isinstance(row, dict):
            raise table.error("vary", "must be tables, each under [[vary]]")
        found += _variations(table.element("vary", k, row), trial)
    names = [variation.name for variation in found]
    paths = [path for variation in found for path in variation.paths]
    for kind, words in (("name", names), ("path", paths)):
        twice = [word for word in words if words.count(word) > 1]
        if twice:
            raise table.error("vary", f"the {kind} {twice[0]!r} stands there twice")
    _require_order(table, paths)
    return found


def require_free_names(
    table: Table, variations: Sequence[Variation], metrics: Sequence[str]
) -> None:
    """Refuse variations that are called as another column of the table is.

    Args:
        table: The study.
        variations: Its variations.
        metrics: Its metrics.

    Raises:
        InputError: One is.
    """
    for variation in variations:
        if variation.name in (*LEADING_COLUMNS, *TRAILING_COLUMNS, *metrics):
            what = f"the table has another column {variation.name!r}; give the variation a name"
            raise table.error("vary", what)


def _require_order(table: Table, paths: Sequence[str]) -> None:
    """Refuse a path below which another before it has set something that it would undo."""
    before: set[str] = set()
    for path in paths:
        if path in before:
            what = f"{path!r} undoes what stands before it for a part of it; let it stand first"
            raise table.error("vary", what)
        parts = split_path(path)
        before |= {join_path(parts[:k]) for k in range(1, len(parts))}
        name, index = indexed(parts[-1])
        if index is not None:
            before.add(join_path([*parts[:-1], name]))


def _variations(table: Table, trial: Trial) -> Iterator[Variation]:
    given = [way for way in _WAYS if way in table]
    paths = _paths(table)
    name = table.text("name", paths[0])
    together = table.flag("together", False)
    relative = _relative(table)
    if len(given) != 1:
        raise table.error("path", f"needs one of {', '.join(_WAYS)}, found {len(given)} of them")
    if given[0] == "box":
        parts = _box(table, name, paths)
    else:
        parts = [Variation(name, paths, _range(table, given[0]))]
    table.close()
    if relative is not None:
        _require_numbers(table, parts)
    for variation in parts:
        try:
            for own in _spelled_out(variation, together, trial):
                yield own if relative is None else _related(own, relative, trial)
        except InputError as error:
            raise InputError(error.what, file=table.file, key=table.key("path")) from None


def _relative(table: Table) -> Relative | None:
    """Whether values are relative to what the experiment has."""
    if table.value("relative", None) is None:
        return None
    if table.value("relative") not in RELATIVE:
        raise table.error("relative", f"must be {' or '.join(map(repr, RELATIVE))}")
    return cast(Relative, table.value("relative"))


def _require_numbers(table: Table, variations: Sequence[Variation]) -> None:
    """Refuse relative values that are no numbers."""
    for variation in variations:
        if variation.is_seed:
            raise table.error("relative", "a seed is relative to nothing")
        for value in variation.listed if variation.is_listed else ():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise table.error("values", f"must be numbers where relative, not {value!r}")


def _related(variation: Variation, relative: Relative, trial: Trial) -> Variation:
    """The variation with what the experiment has at its paths."""
    nominal = tuple(nominal_value(trial.base, path) for path in variation.paths)
    for path, value in zip(variation.paths, nominal, strict=True):
        if relative == "factor" and not np.any(value):
            raise InputError(f"{path} is 0, and so is every factor of it; use relative = 'offset'")
        if relative == "offset" and isinstance(value, tuple):
            raise InputError(f"{path} is a vector; say which number, such as {path}[0], or a box")
    return replace(variation, relative=relative, nominal=nominal)


def _paths(table: Table) -> tuple[str, ...]:
    """One path, or several that take the same value."""
    paths = table.value("path")
    paths = [paths] if isinstance(paths, str) else paths
    if not isinstance(paths, list) or not paths or not all(isinstance(p, str) for p in paths):
        raise table.error("path", f"must be a text or a list of texts, not {paths!r}")
    try:
        return tuple(join_path(split_path(path)) for path in paths)
    except InputError as error:
        raise table.error("path", f"{error.key!r} {error.what}") from None


def _range(table: Table, way: str) -> Range:
    if way == "seed":
        if not table.flag(way):
            raise table.error(way, "must be true")
        return Seed()
    if way in ("values", "grid"):
        return Listed(tuple(_values(table) if way == "values" else _grid(table.table(way))))
    a, b = table.numbers(way, 2)
    if way == "normal":
        if b <= 0:
            raise table.error(way, f"must be mean and standard deviation, above 0, not {b!r}")
        return Normal(a, b)
    if a >= b:
        raise table.error(way, f"must be two numbers that increase, not {a!r} and {b!r}")
    if way == "uniform":
        return Uniform(a, b)
    if a <= 0:
        raise table.error(way, f"must be above 0, not {a!r}")
    return LogUniform(a, b)


def _values(table: Table) -> list[Any]:
    values = table.value("values")
    if not isinstance(values, list) or not values:
        raise table.error("values", "must be a list of at least one value")
    for value in values:
        _require_plain(table, value)
    return values


def _require_plain(table: Table, value: Any) -> None:
    """Refuse what is no number, text, truth value, or list or table of such."""
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            _require_plain(table, inner)
    elif isinstance(value, datetime.date | datetime.time):
        raise table.error("values", f"a date or time is no value of a setting: {value}")
    elif isinstance(value, float) and not math.isfinite(value):
        raise table.error("values", f"must be finite, not {value!r}")


def _grid(table: Table) -> list[float]:
    first, last, count = table.number("from"), table.number("to"), table.whole("count")
    table.close()
    if not 1 <= count <= _MOST_VALUES:
        raise table.error("count", f"must be 1 to {_MOST_VALUES}, not {count}: the grid is empty")
    values: list[float] = np.linspace(first, last, count).tolist()
    return values


def _box(table: Table, name: str, paths: tuple[str, ...]) -> list[Variation]:
    """A vector in a box: a variation an axis; an axis without width is held."""
    box = table.table("box")
    low, high = box.numbers("from", 3), box.numbers("to", 3)
    box.close()
    if any(a > b for a, b in zip(low, high, strict=True)):
        raise table.error("box", f"`from` must not be above `to`: {low} and {high}")
    return [
        Variation(
            f"{name}[{axis}]",
            tuple(f"{path}[{axis}]" for path in paths),
            Listed((a,)) if a == b else Uniform(a, b),
        )
        for axis, (a, b) in enumerate(zip(low, high, strict=True))
    ]


def _spelled_out(variation: Variation, together: bool, trial: Trial) -> Iterator[Variation]:
    """The variation with the names that `*` stands for, tried on the experiment."""
    value = variation.range.at(0.5)
    paths = [_names(path, value, trial) for path in variation.paths]
    if together:
        everything = tuple(path for several in paths for path in several)
        yield Variation(variation.name, everything, variation.range)
        return
    if len({len(several) for several in paths}) > 1:
        raise InputError("with `*` the paths stand for different numbers of names")
    for same in zip(*paths, strict=True):
        name = variation.name if len(paths[0]) == 1 else same[0]
        yield Variation(name, tuple(same), variation.range)


def _names(path: str, value: Any, trial: Trial) -> list[str]:
    """A path, or those that it stands for."""
    parts = split_path(path)
    if EVERY_OTHER not in parts:
        trial.require(path, value)
        return [path]
    place = parts.index(EVERY_OTHER)
    trouble: list[UnknownNameError] = []
    for names in _candidates(trial.base):
        spelled = [join_path([*parts[:place], name, *parts[place + 1 :]]) for name in names]
        try:
            return [inner for one in spelled for inner in _names(one, value, trial)]
        except UnknownNameError as error:
            trouble.append(error)
    raise max(trouble, key=lambda error: len((error.key or "").split(".")))  # got the farthest


def _candidates(experiment: Experiment) -> Iterator[Sequence[str]]:
    """What names there are, where `*` may stand for all of a kind."""
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
