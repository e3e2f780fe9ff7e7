"""Statistics of a study: distributions, worst cases, sensitivities."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy import stats

from cardsflow_fmu.studies.definition.metrics import split_metric
from cardsflow_fmu.studies.definition.outcome import Outcome
from cardsflow_fmu.studies.definition.sampling import Run, is_searched
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.utils.arrays import FloatArray

from .table import Columns

_WORST = 5
_MAX_ERRORS = 50
_GROUPS = 10
_ENOUGH_POINTS = 8  # of Saltelli's design, for Sobol's indices
_ENOUGH = 5 * _GROUPS  # runs, for a share of the variance
_QUANTILES = {"p05": 0.05, "median": 0.5, "p95": 0.95}


@dataclass
class Collected:
    """The numbers of a study's table.

    Attributes:
        hashes: One a run.
        inputs: By the name of the variation, one a run; NaN for other values.
        metrics: By name, one a run; NaN of a failed run.
        failures: Number of runs by error.
        overheads: Time of every complete run beyond its simulation, in [s].
    """

    hashes: list[str] = field(default_factory=list)
    inputs: dict[str, FloatArray] = field(default_factory=dict)
    metrics: dict[str, FloatArray] = field(default_factory=dict)
    failures: dict[str, int] = field(default_factory=dict)
    overheads: list[float] = field(default_factory=list)


def collect(columns: Columns, rows: Iterable[tuple[Run, Outcome]]) -> Collected:
    """Return the numbers of a study."""
    collected = Collected()
    inputs: dict[str, list[float]] = {name: [] for name in columns.variations}
    metrics: dict[str, list[float]] = {name: [] for name in columns.metrics}
    for run, outcome in rows:
        collected.hashes.append(run.hash)
        for name, numbers in inputs.items():
            numbers.append(_number(run.values[name]))
        for name, numbers in metrics.items():
            numbers.append(_number(outcome.metrics.get(name)))
        if outcome.error is None:
            collected.overheads.append(outcome.overhead)
        else:
            full = len(collected.failures) >= _MAX_ERRORS
            error = "others" if full and outcome.error not in collected.failures else outcome.error
            collected.failures[error] = collected.failures.get(error, 0) + 1
    collected.inputs = {name: np.array(numbers) for name, numbers in inputs.items()}
    collected.metrics = {name: np.array(numbers) for name, numbers in metrics.items()}
    return collected


def distributions(collected: Collected) -> dict[str, dict[str, float | int]]:
    """Return the distribution of every metric over the runs that have it."""
    found: dict[str, dict[str, float | int]] = {}
    with np.errstate(over="ignore"):  # squares of large values
        for name, values in collected.metrics.items():
            there = values[np.isfinite(values)]
            if there.size:
                found[name] = _distribution(there)
    return found


def _distribution(there: FloatArray) -> dict[str, float | int]:
    return {
        "count": int(there.size),
        "min": float(there.min()),
        "mean": float(there.mean()),
        "max": float(there.max()),
        "deviation": float(there.std()),
        **{key: float(np.quantile(there, q)) for key, q in _QUANTILES.items()},
    }


def worst_runs(collected: Collected) -> dict[str, list[int]]:
    """Rows of the worst runs by each metric, the worst first; the metrics are those of `ranked`."""
    return {name: rows[:_WORST] for name, rows in ranked(collected).items()}


def best_runs(collected: Collected) -> dict[str, int]:
    """Return the row of the best run by each metric; the metrics are those of `ranked`."""
    return {name: rows[-1] for name, rows in ranked(collected).items()}


def ranked(collected: Collected) -> dict[str, list[int]]:
    """Return rows of all runs by each metric that they have, the worst first.

    Metrics that are equal in all runs are left out, and so are those of single muscles.
    """
    found = {}
    for name, values in collected.metrics.items():
        metric, muscle = split_metric(name)
        there = np.flatnonzero(~np.isnan(values))
        if muscle is None and there.size and np.any(values[there] != values[there[0]]):
            badness = values[there] if metric.large_is_good else -values[there]
            found[name] = there[np.argsort(badness, kind="stable")].tolist()
    return found


def sensitivities(study: Study, collected: Collected) -> dict[str, dict[str, Any]]:
    """Return the influence of each variation on each metric.

    A study with the sampler `sensitivity` gives Sobol's indices: `first`, the part of the variance
    that a variation makes alone, and `total`, with all it makes together with others. The others
    give `rank`, Spearman's rank correlation, from -1 to 1, and of enough runs `share`: the part of
    the variance that the variation makes alone, whatever its direction, estimated from groups.
    """
    names = [v.name for v in study.variations if is_searched(v)]
    if study.sampler == "sensitivity" and study.optimise is None:
        assert study.count is not None
        return _sobol(names, study.count, collected)
    return _ranks(names, collected)


def _sobol(names: list[str], count: int, collected: Collected) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for metric, values in collected.metrics.items():
        f = values.reshape(len(names) + 2, count)
        f = f[:, np.isfinite(f).all(axis=0)]  # a point counts with all its runs, or not at all
        if f.shape[1] >= _ENOUGH_POINTS and np.ptp(f[:2]) > 0:
            first, total = sobol_indices(f)
            found[metric] = {
                name: {"first": float(a), "total": float(b)}
                for name, a, b in zip(names, first, total, strict=True)
            }
    return found


def sobol_indices(f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """First-order and total indices, both of shape (d,).

    The estimators are those of A. Saltelli et al., "Variance based sensitivity analysis of model
    output", Computer Physics Communications, 2010, table 2.

    Args:
        f: A metric at the points A, at B, and at A with one column of B after another, shape
            (d + 2, n).
    """
    f = f - f[:2].mean()
    f_A, f_B, f_AB = f[0], f[1], f[2:]
    variance = f[:2].var()
    first = np.mean(f_B * (f_AB - f_A), axis=1) / variance
    total = 0.5 * np.mean((f_A - f_AB) ** 2, axis=1) / variance
    return first, total


def _ranks(names: list[str], collected: Collected) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for metric, values in collected.metrics.items():
        ranks = {}
        for name in names:
            inputs = collected.inputs[name]
            both = np.isfinite(inputs) & np.isfinite(values)
            if both.sum() > 2 and np.ptp(inputs[both]) > 0 and np.ptp(values[both]) > 0:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    rank = float(stats.spearmanr(inputs[both], values[both]).statistic)
                ranks[name] = {"rank": rank}
                if both.sum() >= _ENOUGH:
                    ranks[name]["share"] = variance_share(inputs[both], values[both])
        if ranks:
            found[metric] = ranks
    return found


def variance_share(x: FloatArray, y: FloatArray) -> float:
    """Return the part of the variance of y that its mean over groups of equal x makes, from 0 to 1.

    The correlation ratio, adjusted for what as many groups would make of noise; a first-order Sobol
    index from runs that were made for something else.

    Args:
        x: A variation, shape (n,); in groups of its neighbours if it has many values.
        y: A metric, shape (n,).
    """
    n = len(x)
    known = np.unique(x)
    if len(known) <= _GROUPS:
        groups = [y[x == value] for value in known]
    else:
        groups = np.array_split(y[np.argsort(x, kind="stable")], _GROUPS)
    between = sum(len(group) * (group.mean() - y.mean()) ** 2 for group in groups)
    ratio = between / np.sum((y - y.mean()) ** 2)
    return float(max(0.0, 1.0 - (1.0 - ratio) * (n - 1) / (n - len(groups))))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return float("nan")
    return float(value)
