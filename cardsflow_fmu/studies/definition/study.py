"""What a study is: an experiment, what is varied, how it is sampled, and what is looked at."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from .variations import Variation

Engine = Literal["direct", "fmu", "native"]
Sampler = Literal["grid", "list", "sobol", "latin_hypercube", "monte_carlo", "sensitivity"]
Method = Literal["differential_evolution", "cma_es"]
TableKind = Literal["csv", "parquet"]

SAMPLERS: tuple[Sampler, ...] = (
    "grid",
    "list",
    "sobol",
    "latin_hypercube",
    "monte_carlo",
    "sensitivity",
)
METHODS: tuple[Method, ...] = ("differential_evolution", "cma_es")


STUDY_FILE = Path("study.toml")
"""What a study is called that has a folder to itself."""


@dataclass(frozen=True, slots=True)
class Constraint:
    """What a robot must meet to count.

    Attributes:
        metric: Name of a metric.
        at_least, at_most: Its bounds, in its unit; None where there is none.
    """

    metric: str
    at_least: float | None
    at_most: float | None

    def violation(self, value: float) -> float:
        """By how much a value misses the bounds; 0 within them."""
        below = 0.0 if self.at_least is None else self.at_least - value
        above = 0.0 if self.at_most is None else value - self.at_most
        return max(below, above, 0.0)


@dataclass(frozen=True, slots=True)
class Optimise:
    """A search for the best instead of a sampling.

    Attributes:
        method: The algorithm.
        objective: Name of the metric that is made small, or large.
        maximise: Whether large is good.
        population: Robots in a generation.
        generations: Most generations.
        seeds: One independent search each.
        constraints: What a robot must meet.
    """

    method: Method
    objective: str
    maximise: bool
    population: int
    generations: int
    seeds: tuple[int, ...]
    constraints: tuple[Constraint, ...]

    @property
    def most_runs(self) -> int:
        """How many runs all searches have together, unless one ends early."""
        return len(self.seeds) * self.generations * self.population


@dataclass(frozen=True, slots=True)
class Box:
    """Joint positions between which the workspace is looked at.

    Attributes:
        lower, upper: In [rad] or [m], in the order of q.
        points: Poses along each coordinate.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    points: int


@dataclass(frozen=True)
class Study:
    """A study, complete and checked.

    Attributes:
        file: Where it comes from.
        experiment: The experiment.toml, or the folder that holds one.
        settings: Changes to it that all runs share, by full key.
        engine: Plain Python objects in the worker, FMUs, or a loop in C: equal results, but for
            rounding in C.
        seed: Where all random numbers come from.
        variations: What is varied.
        sampler: How the variations are combined.
        count: How many samples; None for `grid` and `list`.
        metrics: What is looked at, `*` spelled out.
        box: Where the workspace is looked at; None for the joint limits.
        optimise: A search; None for a sampling.
        output: Folder for runs, table and report.
        tables: Kinds of the table.
    """

    file: Path
    experiment: Path
    settings: Mapping[str, Any]
    engine: Engine
    seed: int
    variations: tuple[Variation, ...]
    sampler: Sampler
    count: int | None
    metrics: tuple[str, ...]
    box: Box | None
    optimise: Optimise | None
    output: Path
    tables: tuple[TableKind, ...] = field(default=("csv",))

    @property
    def name(self) -> str:
        """Name of its file, without the ending; that of its folder for a study.toml."""
        own = self.file.stem
        return self.file.resolve().parent.name if own == STUDY_FILE.stem else own

    @staticmethod
    def load(path: str | Path) -> Study:
        """Read a study.

        Args:
            path: A study.toml, or the folder that holds one.

        Raises:
            InputError: Something in it, or in its experiment, is wrong; file and key are named.
        """
        from .reader import read_study

        return read_study(Path(path))
