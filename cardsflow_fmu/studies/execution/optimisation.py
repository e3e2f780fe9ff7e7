"""Optimisation of a robot by generations of runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run, make_run, values_at
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.studies.definition.tables import Optimise
from cardsflow_fmu.utils.arrays import FloatArray

from .optimisers import search

RunGeneration = Callable[[Iterable[Run]], list[Outcome]]
"""Function that executes the runs without an outcome and returns all outcomes, in order."""

# costs of violated constraints and of failed runs, larger than any objective
_VIOLATION, _FAILURE = 1e12, 1e15


@dataclass
class Search:
    """The state of a search.

    Attributes:
        runs: All runs with their outcomes, in order.
        history: Best objective after each generation, by the name of the search; NaN before a run
            satisfies the constraints.
        best: Index of the best run that satisfies the constraints, or None.
        lowest: Cost of the best run.
    """

    runs: list[tuple[Run, Outcome]] = field(default_factory=list)
    history: dict[str, list[float]] = field(default_factory=dict)
    best: int | None = None
    lowest: float = _VIOLATION


def optimise(study: Study, fingerprint: str, run_generation: RunGeneration) -> Search:
    """Search for the best robot, once for each seed."""
    assert study.optimise is not None
    result, settings = Search(), study.optimise
    dimensions = sum(variation.has_range for variation in study.variations)
    for number in settings.seeds:
        history = result.history.setdefault(f"seed {number}", [])
        lowest = _VIOLATION

        def evaluate(points: Sequence[FloatArray], history: list[float] = history) -> list[float]:
            nonlocal lowest
            begin = len(result.runs)
            runs = [
                make_run(study, fingerprint, begin + k, values_at(study.variations, point.tolist()))
                for k, point in enumerate(points)
            ]
            outcomes = run_generation(runs)
            result.runs += zip(runs, outcomes, strict=True)
            costs = [cost(settings, outcome) for outcome in outcomes]
            for k, value in enumerate(costs):
                if value < result.lowest:
                    result.best, result.lowest = begin + k, value
            lowest = min(lowest, *costs)
            history.append(_objective(settings, lowest) if lowest < _VIOLATION else math.nan)
            return costs

        search(settings, dimensions, study.seed + number, evaluate)
    return result


def cost(settings: Optimise, outcome: Outcome) -> float:
    """Return the cost: the objective, or a larger value if a constraint is violated."""
    names = [settings.objective, *(c.metric for c in settings.constraints)]
    values = [_finite(outcome.metrics.get(name)) for name in names]
    if not outcome.complete or any(math.isnan(value) for value in values):
        return _FAILURE
    pairs = zip(settings.constraints, values[1:], strict=True)
    violation = sum(constraint.violation(value) for constraint, value in pairs)
    if violation > 0.0:
        return min(_VIOLATION + violation * 1e3, _FAILURE)
    return _objective(settings, values[0])


def _finite(value: Any) -> float:
    """Return a finite number, or NaN."""
    return float(value) if value is not None and math.isfinite(value) else math.nan


def _objective(settings: Optimise, value: float) -> float:
    """Convert an objective to a cost, or a cost to an objective."""
    return -value if settings.maximise else value
