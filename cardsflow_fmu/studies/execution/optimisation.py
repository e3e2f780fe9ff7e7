"""The search for the best robot, by generations of runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run, is_searched, make_run, searched_values
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.definition.tables import Optimise
from cardsflow_fmu.utils.arrays import FloatArray

from .optimisers import search

RunGeneration = Callable[[Iterable[Run]], list[Outcome]]
"""Does runs that have no outcome yet; returns all outcomes, in order."""

_MISSES, _FAILS = 1e12, 1e15  # costs above any that meets the constraints


@dataclass
class Search:
    """The state of a search.

    Attributes:
        runs: All runs with their outcomes, in order.
        history: By the name of the search, the best objective after each generation; NaN before
            anything meets the constraints.
        best: Index of the best run that meets the constraints; None if there is none.
    """

    runs: list[tuple[Run, Outcome]] = field(default_factory=list)
    history: dict[str, list[float]] = field(default_factory=dict)
    best: int | None = None
    lowest: float = _MISSES


def optimise(study: Study, fingerprint: str, run_generation: RunGeneration) -> Search:
    """Search for the best robot, once a seed.

    Args:
        study: A study with `optimise`.
        fingerprint: Hash of the common part of all runs.
        run_generation: Does a generation.

    Raises:
        InputError: The algorithm is not installed.
    """
    assert study.optimise is not None
    found, settings = Search(), study.optimise
    dimensions = sum(is_searched(variation) for variation in study.variations)
    for number in settings.seeds:
        history = found.history.setdefault(f"seed {number}", [])
        lowest = _MISSES

        def evaluate(points: Sequence[FloatArray], history: list[float] = history) -> list[float]:
            nonlocal lowest
            begin = len(found.runs)
            runs = [
                make_run(
                    study, fingerprint, begin + k, searched_values(study.variations, point.tolist())
                )
                for k, point in enumerate(points)
            ]
            outcomes = run_generation(runs)
            found.runs += zip(runs, outcomes, strict=True)
            costs = [cost(settings, outcome) for outcome in outcomes]
            for k, value in enumerate(costs):
                if value < found.lowest:
                    found.best, found.lowest = begin + k, value
            lowest = min(lowest, *costs)
            history.append(_objective(settings, lowest) if lowest < _MISSES else math.nan)
            return costs

        search(settings, dimensions, study.seed + number, evaluate)
    return found


def cost(settings: Optimise, outcome: Outcome) -> float:
    """Return the cost: the objective, or more than any objective where a constraint is missed."""
    names = [settings.objective, *(c.metric for c in settings.constraints)]
    values = [_finite(outcome.metrics.get(name)) for name in names]
    if not outcome.complete or any(math.isnan(value) for value in values):
        return _FAILS
    pairs = zip(settings.constraints, values[1:], strict=True)
    missed = sum(constraint.violation(value) for constraint, value in pairs)
    if missed > 0.0:
        return min(_MISSES + missed * 1e3, _FAILS)
    return _objective(settings, values[0])


def _finite(value: Any) -> float:
    """Return a number; NaN for anything else."""
    return float(value) if value is not None and math.isfinite(value) else math.nan


def _objective(settings: Optimise, value: float) -> float:
    """Return the cost of an objective, or the objective of a cost."""
    return -value if settings.maximise else value
