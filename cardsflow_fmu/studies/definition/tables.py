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
from cardsflow_fmu.experiment.settings.run import Compute, ModelCoupling

from .variations import Listed as ListedValues
from .variations import LogUniform, Normal, Range, Relative, Seed, Uniform

Sampler = Literal["grid", "list", "sobol", "latin_hypercube", "monte_carlo", "sensitivity"]
Method = Literal["differential_evolution", "cma_es"]
TableKind = Literal["csv", "parquet"]

MAX_RUNS = 1_000_000
_AtLeast1 = Annotated[int, Field(ge=1), AS_WHOLE]
_Count = Annotated[Whole, Field(json_schema_extra={"minimum": 1})]
"""Whose bounds are checked with what they count."""
_FromZero = Annotated[int, Field(ge=0), AS_WHOLE]


def _one_metric(name: str) -> str:
    if "*" in name:
        raise SettingError("must be one metric, without `*`")
    return name


def _plain(values: Any) -> Any:
    """Reject what is not a number, text, truth value, or list or table of such."""
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
        raise SettingError(f"{error.key!r} {error.what}") from None


Metric = Annotated[Text, AfterValidator(_one_metric)]


class GridSettings(Table):
    """Evenly spaced values."""

    first: float = setting("the first", alias="from")
    last: float = setting("the last", alias="to")
    count: _Count = setting("how many")

    @model_validator(mode="after")
    def _check_count(self) -> Self:
        if not 1 <= self.count <= MAX_RUNS:
            grid = "the grid is empty" if self.count < 1 else "the grid is too fine"
            raise SettingError(f"must be 1 to {MAX_RUNS}, not {self.count}: {grid}", key="count")
        return self


class BoxSettings(Table):
    """A vector drawn in a box."""

    low: Vector3 = setting("its lower corner", alias="from")
    high: Vector3 = setting("its upper corner", alias="to")


class VarySettings(Table):
    """Something that is varied; one of the keys that give values is needed."""

    paths: Annotated[
        tuple[Text, ...],
        Listed,
        Field(min_length=1),
        AfterValidator(_paths),
        ShortForm(_listed, {"type": "string", "minLength": 1}),
    ] = setting("full key in the experiment, or several; * for all names", alias="path")
    name: Text = setting("in tables and figures (default: the path)", None)
    together: bool = setting("whether all names of * take the same value", False)
    relative: Relative = setting("values are relative to what the experiment has", None)
    values: Annotated[tuple[Any, ...], Listed, Field(min_length=1), AfterValidator(_plain)] = (
        setting("these values", None)
    )
    grid: GridSettings = setting("evenly spaced values", None)
    uniform: Pair = setting("drawn between two numbers", None)
    loguniform: Pair = setting("drawn between two numbers, evenly in their logarithm", None)
    normal: Pair = setting("drawn about a mean, by a standard deviation", None)
    box: BoxSettings = setting("a vector drawn in a box", None)
    seed: Literal[True] = setting("a different seed for every run", None)

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        given = [way for way in _WAYS if getattr(self, way) is not None]
        if len(given) != 1:
            what = f"needs one of {', '.join(_WAYS)}, found {len(given)} of them"
            raise SettingError(what, key="path")
        way = given[0]
        if way in ("uniform", "loguniform"):
            a, b = getattr(self, way)
            if a >= b:
                raise SettingError(
                    f"must be two numbers that increase, not {a!r} and {b!r}", key=way
                )
            if way == "loguniform" and a <= 0:
                raise SettingError(f"must be above 0, not {a!r}", key=way)
        if way == "normal" and self.normal[1] <= 0:
            what = f"must be mean and standard deviation, above 0, not {self.normal[1]!r}"
            raise SettingError(what, key=way)
        if way == "box" and any(a > b for a, b in zip(self.box.low, self.box.high, strict=True)):
            what = f"`from` must not be above `to`: {self.box.low} and {self.box.high}"
            raise SettingError(what, key=way)
        if self.relative is not None and way == "seed":
            raise SettingError("a seed is relative to nothing", key="relative")
        for value in self.values or () if self.relative is not None else ():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise SettingError(f"must be numbers where relative, not {value!r}", key="values")
        return self

    def ranges(self) -> Iterator[tuple[str, Range]]:
        """The ranges of values, each with what it adds to the paths: one an axis of a box.

        An axis without width is held.
        """
        if self.box is not None:
            for axis, (a, b) in enumerate(zip(self.box.low, self.box.high, strict=True)):
                yield f"[{axis}]", ListedValues((a,)) if a == b else Uniform(a, b)
        elif self.values is not None:
            yield "", ListedValues(self.values)
        elif self.grid is not None:
            grid = np.linspace(self.grid.first, self.grid.last, self.grid.count)
            yield "", ListedValues(tuple(grid.tolist()))
        elif self.seed:
            yield "", Seed()
        elif self.normal is not None:
            yield "", Normal(*self.normal)
        elif self.uniform is not None:
            yield "", Uniform(*self.uniform)
        else:
            yield "", LogUniform(*self.loguniform)


_WAYS = ("values", "grid", "uniform", "loguniform", "normal", "box", "seed")


class Constraint(Table):
    """What a robot must meet to count."""

    metric: Metric = setting("its name")
    at_least: float | None = setting("lower bound, in the metric's unit", None)
    at_most: float | None = setting("upper bound, in the metric's unit", None)

    @model_validator(mode="after")
    def _check_bounds(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise SettingError("needs at_least or at_most", key="metric")
        return self

    def violation(self, value: float) -> float:
        """By how much a value misses the bounds; 0 within them."""
        below = 0.0 if self.at_least is None else self.at_least - value
        above = 0.0 if self.at_most is None else value - self.at_most
        return max(below, above, 0.0)


class Optimise(Table):
    """A search for the best instead of a sampling."""

    method: Method = setting("the algorithm", "differential_evolution")
    objective: Metric = setting("the metric that is made small, or large")
    maximise: bool = setting("whether large is good", False)
    population: Annotated[int, Field(ge=5), AS_WHOLE] = setting("robots in a generation", 16)
    generations: _AtLeast1 = setting("most generations", 30)
    seeds: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Listed, Field(min_length=1)] = (
        setting("one independent search each", (0,))
    )
    constraints: Annotated[tuple[Constraint, ...], Listed] = setting("what a robot must meet", ())

    @model_validator(mode="after")
    def _check_runs(self) -> Self:
        if len(set(self.seeds)) < len(self.seeds):
            raise SettingError(f"must be different, not {list(self.seeds)!r}", key="seeds")
        if self.most_runs > MAX_RUNS:
            raise SettingError(f"{self.most_runs} runs; at most {MAX_RUNS}", key="generations")
        return self

    @property
    def most_runs(self) -> int:
        """How many runs all searches have together, unless one ends early."""
        return len(self.seeds) * self.generations * self.population


class Box(Table):
    """Joint positions between which the workspace is looked at."""

    lower: tuple[float, ...] = named_setting(
        "coordinate", "in rad or m (default: the joint limits)", None
    )
    upper: tuple[float, ...] = named_setting(
        "coordinate", "in rad or m (default: the joint limits)", None
    )
    points: _Count = setting("poses along each coordinate", 5)


class StudyTables(Table):
    """A study of CARDSFlow: an experiment, varied and run many times."""

    experiment: File = setting("an experiment.toml, or the folder that holds one")
    settings: dict[str, Any] = setting("changes to the experiment that all runs share", {})
    compute: Compute = setting("who computes, as run.compute of an experiment", "c")
    coupling: ModelCoupling = setting("of the models, as run.coupling of an experiment", "direct")
    seed: _FromZero = setting("where all random numbers come from", 0)
    sampler: Sampler = setting("how the variations are combined", None)
    count: _Count = setting("number of samples", None)
    metrics: Annotated[tuple[Text, ...], Listed, Field(min_length=1)] = setting(
        "what is looked at", None
    )
    output: File = setting("folder for the results, relative to this file", None)
    tables: Annotated[tuple[TableKind, ...], Listed, Field(min_length=1)] = setting(
        "kinds of the table", ("csv",), kind="kind of table"
    )
    vary: Annotated[tuple[VarySettings, ...], Listed] = setting("what is varied", ())
    optimise: Optimise = setting("a search for the best instead of a sampling", None)
    workspace: Box = setting("joint positions between which the workspace is looked at", None)
