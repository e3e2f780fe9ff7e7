"""All tables of study.toml."""

from __future__ import annotations

import datetime
import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.key_path import join_path, split_path
from cardsflow_fmu.experiment.config.messages import SettingError
from cardsflow_fmu.experiment.config.names import named_setting
from cardsflow_fmu.experiment.config.table import (
    AS_WHOLE,
    File,
    Listed,
    Pair,
    ShortForm,
    Table,
    Text,
    Vector3,
    Whole,
    setting,
)
from cardsflow_fmu.experiment.settings.run import Compute

from .variations import Kind, Range, Relative

Sampler = Literal["grid", "list", "sobol", "latin_hypercube", "monte_carlo", "sensitivity"]
Method = Literal["differential_evolution", "cma_es"]

MAX_RUNS = 1_000_000
_AtLeast1 = Annotated[int, Field(ge=1), AS_WHOLE]
_Count = Annotated[Whole, Field(json_schema_extra={"minimum": 1})]
"""A count; validators check its limits, to state the reason."""
_FromZero = Annotated[int, Field(ge=0), AS_WHOLE]


def _one_metric(name: str) -> str:
    if "*" in name:
        raise SettingError("must be one metric, without `*`")
    return name


def _plain(values: Any) -> Any:
    """Reject values other than finite numbers, texts, booleans, and lists or tables of them."""
    for value in values.values() if isinstance(values, dict) else values:
        if isinstance(value, dict | list):
            _plain(value)
        elif isinstance(value, datetime.date | datetime.time):
            raise SettingError(f"a date or time is not allowed in a setting: {value}")
        elif isinstance(value, float) and not math.isfinite(value):
            raise SettingError(f"must be finite, not {value!r}")
    return values


def _listed(path: Any) -> Any:
    return [path] if isinstance(path, str) else path


def _paths(paths: tuple[str, ...]) -> tuple[str, ...]:
    try:
        return tuple(join_path(split_path(path)) for path in paths)
    except InputError as error:
        raise SettingError(f"{error.key!r} {error.problem}") from None


Metric = Annotated[Text, AfterValidator(_one_metric)]


class GridSettings(Table):
    """Evenly spaced values."""

    first: float = setting("first value", alias="from")
    last: float = setting("last value", alias="to")
    count: _Count = setting("number of values")

    @model_validator(mode="after")
    def _check_count(self) -> Self:
        if not 1 <= self.count <= MAX_RUNS:
            raise SettingError(f"must be from 1 to {MAX_RUNS}, not {self.count}", key="count")
        return self


class BoxSettings(Table):
    """A random vector in a box."""

    low: Vector3 = setting("lower corner", alias="from")
    high: Vector3 = setting("upper corner", alias="to")


class VarySettings(Table):
    """A variation; one of the keys that specify values is required."""

    paths: Annotated[
        tuple[Text, ...],
        Listed,
        Field(min_length=1),
        AfterValidator(_paths),
        ShortForm(_listed, {"type": "string", "minLength": 1}),
    ] = setting("full key in the experiment, or several keys; * matches all names", alias="path")
    name: Text = setting("name in tables and figures (default: the path)", None)
    together: bool = setting("whether all names that * matches have the same value", False)
    relative: Relative = setting("values are relative to the value in the experiment", None)
    values: Annotated[tuple[Any, ...], Listed, Field(min_length=1), AfterValidator(_plain)] = (
        setting("list of values", None)
    )
    grid: GridSettings = setting("evenly spaced values", None)
    uniform: Pair = setting("uniform distribution between two numbers", None)
    loguniform: Pair = setting("log-uniform distribution between two numbers", None)
    normal: Pair = setting("normal distribution with mean and standard deviation", None)
    box: BoxSettings = setting("uniform distribution of a vector in a box", None)
    seed: Literal[True] = setting("a different seed for every run", None)

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        ranges = [key for key in _RANGE_KEYS if getattr(self, key) is not None]
        if len(ranges) != 1:
            problem = f"requires exactly one of {', '.join(_RANGE_KEYS)}, found {len(ranges)}"
            raise SettingError(problem, key="path")
        key = ranges[0]
        if key in ("uniform", "loguniform"):
            a, b = getattr(self, key)
            if a >= b:
                raise SettingError(f"must be two increasing numbers, not {a!r} and {b!r}", key=key)
            if key == "loguniform" and a <= 0:
                raise SettingError(f"must be positive, not {a!r}", key=key)
        if key == "normal" and self.normal[1] <= 0:
            problem = f"the standard deviation must be positive, not {self.normal[1]!r}"
            raise SettingError(problem, key=key)
        if key == "box" and any(a > b for a, b in zip(self.box.low, self.box.high, strict=True)):
            problem = f"`from` must not be above `to`: {self.box.low} and {self.box.high}"
            raise SettingError(problem, key=key)
        if self.relative is not None and key == "seed":
            raise SettingError("a seed cannot be relative", key="relative")
        for value in self.values or () if self.relative is not None else ():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise SettingError(f"relative values must be numbers, not {value!r}", key="values")
        return self

    def ranges(self) -> Iterator[tuple[str, Range]]:
        """Yield the ranges of values, each with its suffix for the paths.

        A box has one range for each axis. An axis with zero width is constant.
        """
        if self.box is not None:
            for axis, (a, b) in enumerate(zip(self.box.low, self.box.high, strict=True)):
                yield f"[{axis}]", Range("values", (a,)) if a == b else Range("uniform", (a, b))
        elif self.grid is not None:
            grid = np.linspace(self.grid.first, self.grid.last, self.grid.count)
            yield "", Range("values", tuple(grid.tolist()))
        elif self.seed:
            yield "", Range("seed")
        else:
            kinds: tuple[Kind, ...] = ("values", "uniform", "loguniform", "normal")
            kind = next(kind for kind in kinds if getattr(self, kind) is not None)
            yield "", Range(kind, getattr(self, kind))


_RANGE_KEYS = ("values", "grid", "uniform", "loguniform", "normal", "box", "seed")


class Constraint(Table):
    """A constraint on a metric of the robot."""

    metric: Metric = setting("name of the metric")
    at_least: float | None = setting("lower limit, in the unit of the metric", None)
    at_most: float | None = setting("upper limit, in the unit of the metric", None)

    @model_validator(mode="after")
    def _check_bounds(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise SettingError("requires at_least or at_most", key="metric")
        return self

    def violation(self, value: float) -> float:
        """Return the violation of the limits by a value, or 0."""
        below = 0.0 if self.at_least is None else self.at_least - value
        above = 0.0 if self.at_most is None else value - self.at_most
        return max(below, above, 0.0)


class Optimise(Table):
    """An optimisation instead of a sampling."""

    method: Method = setting("algorithm", "differential_evolution")
    objective: Metric = setting("metric that is minimised or maximised")
    maximise: bool = setting("whether to maximise the objective", False)
    population: Annotated[int, Field(ge=5), AS_WHOLE] = setting("robots per generation", 16)
    generations: _AtLeast1 = setting("maximum number of generations", 30)
    seeds: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Listed, Field(min_length=1)] = (
        setting("seeds of independent searches", (0,))
    )
    constraints: Annotated[tuple[Constraint, ...], Listed] = setting("constraints of the robot", ())

    @model_validator(mode="after")
    def _check_runs(self) -> Self:
        if len(set(self.seeds)) < len(self.seeds):
            raise SettingError(f"must be unique, not {list(self.seeds)!r}", key="seeds")
        if self.max_runs > MAX_RUNS:
            problem = f"results in {self.max_runs} runs; the maximum is {MAX_RUNS}"
            raise SettingError(problem, key="generations")
        return self

    @property
    def max_runs(self) -> int:
        """Total number of runs of all searches, unless a search ends early."""
        return len(self.seeds) * self.generations * self.population


class Box(Table):
    """Joint positions of the workspace."""

    lower: tuple[float, ...] = named_setting(
        "coordinate", "in rad or m (default: the joint limits)", None
    )
    upper: tuple[float, ...] = named_setting(
        "coordinate", "in rad or m (default: the joint limits)", None
    )
    points: _Count = setting("number of poses per coordinate", 5)


class StudyTables(Table):
    """A study of CARDSFlow: many runs of an experiment with variations."""

    experiment: File = setting("an experiment.toml, or its folder")
    settings: dict[str, Any] = setting("changes of the experiment for all runs", {})
    compute: Compute = setting("engine, see run.compute of an experiment", "c")
    seed: _FromZero = setting("seed of all random numbers", 0)
    sampler: Sampler = setting("method that combines the variations", None)
    count: _Count = setting("number of samples", None)
    metrics: Annotated[tuple[Text, ...], Listed, Field(min_length=1)] = setting(
        "metrics of each run", None
    )
    output: File = setting("folder for the results, relative to this file", None)
    vary: Annotated[tuple[VarySettings, ...], Listed] = setting("variations", ())
    optimise: Optimise = setting("an optimisation instead of a sampling", None)
    workspace: Box = setting("joint positions of the workspace", None)
