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
from cardsflow_fmu.studies.definition.sampling import Run
from cardsflow_fmu.studies.definition.study import Study
from cardsflow_fmu.utils.arrays import FloatArray

from .table import Columns

_MAX_ERRORS = 50
_GROUPS = 10
_MIN_POINTS = 8  # points of Saltelli's design for Sobol indices
_MIN_RUNS = 5 * _GROUPS  # runs for a share of the variance
_QUANTILES = {"p05": 0.05, "median": 0.5, "p95": 0.95}


@dataclass
class Collected:
    """Values of all runs of a study.

    Attributes:
        inputs: Value in each run, by the name of the variation; NaN for values that are not
            numbers.
        metrics: Value in each run, by the name of the metric; NaN for a failed run.
        failures: Number of runs by error.
        overheads: Time of every complete run in addition to its simulation, in [s].
    """

    hashes: list[str] = field(default_factory=list)
    inputs: dict[str, FloatArray] = field(default_factory=dict)
    metrics: dict[str, FloatArray] = field(default_factory=dict)
    failures: dict[str, int] = field(default_factory=dict)
    overheads: list[float] = field(default_factory=list)


def collect(columns: Columns, rows: Iterable[tuple[Run, Outcome]]) -> Collected:
    """Return the values of all runs of a study."""
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
    by_metric: dict[str, dict[str, float | int]] = {}
    with np.errstate(over="ignore"):  # squares of large values
        for name, values in collected.metrics.items():
            finite = values[np.isfinite(values)]
            if finite.size:
                by_metric[name] = _distribution(finite)
    return by_metric


def _distribution(values: FloatArray) -> dict[str, float | int]:
    return {
        "count": int(values.size),
        "min": float(values.min()),
        "mean": float(values.mean()),
        "max": float(values.max()),
        "deviation": float(values.std()),
        **{key: float(np.quantile(values, q)) for key, q in _QUANTILES.items()},
    }


def rank_runs(collected: Collected) -> dict[str, list[int]]:
    """Return the rows of all runs with a value by metric, the worst first.

    Metrics that are equal in all runs and metrics of single muscles are omitted.
    """
    by_metric = {}
    for name, values in collected.metrics.items():
        metric, muscle = split_metric(name)
        rows = np.flatnonzero(~np.isnan(values))
        if muscle is None and rows.size and np.any(values[rows] != values[rows[0]]):
            quality = values[rows] if metric.large_is_good else -values[rows]
            by_metric[name] = rows[np.argsort(quality, kind="stable")].tolist()
    return by_metric


def sensitivities(study: Study, collected: Collected) -> dict[str, dict[str, Any]]:
    """Return the influence of each variation on each metric.

    With the sampler `sensitivity` these are Sobol indices: `first` is the share of the variance
    caused by the variation itself, `total` also includes its interactions with other variations.
    With other samplers, `rank` is Spearman's rank correlation, from -1 to 1. If there are enough
    runs, `share` is the share of the variance caused by the variation itself, estimated from groups
    of runs.
    """
    names = [v.name for v in study.variations if v.has_range]
    if study.sampler == "sensitivity" and study.optimise is None:
        assert study.count is not None
        return _sobol(names, study.count, collected)
    return _ranks(names, collected)


def _sobol(names: list[str], count: int, collected: Collected) -> dict[str, dict[str, Any]]:
    by_metric: dict[str, dict[str, Any]] = {}
    for metric, values in collected.metrics.items():
        f = values.reshape(len(names) + 2, count)
        f = f[:, np.isfinite(f).all(axis=0)]  # omit a point if one of its runs failed
        if f.shape[1] >= _MIN_POINTS and np.ptp(f[:2]) > 0:
            first, total = sobol_indices(f)
            by_metric[metric] = {
                name: {"first": float(a), "total": float(b)}
                for name, a, b in zip(names, first, total, strict=True)
            }
    return by_metric


def sobol_indices(f: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return first-order and total Sobol indices, both of shape (d,).

    The estimators are defined in A. Saltelli et al., "Variance based sensitivity analysis of model
    output", Computer Physics Communications, 2010, table 2.

    Args:
        f: A metric at the points A, at B, and at A with column j of B for each j, shape (d + 2, n).
    """
    f = f - f[:2].mean()
    f_A, f_B, f_AB = f[0], f[1], f[2:]
    variance = f[:2].var()
    first = np.mean(f_B * (f_AB - f_A), axis=1) / variance
    total = 0.5 * np.mean((f_A - f_AB) ** 2, axis=1) / variance
    return first, total


def _ranks(names: list[str], collected: Collected) -> dict[str, dict[str, Any]]:
    by_metric: dict[str, dict[str, Any]] = {}
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
                if both.sum() >= _MIN_RUNS:
                    ranks[name]["share"] = variance_share(inputs[both], values[both])
        if ranks:
            by_metric[metric] = ranks
    return by_metric


def variance_share(x: FloatArray, y: FloatArray) -> float:
    """Return the share of the variance of y between groups of equal x, from 0 to 1.

    This is the correlation ratio, corrected for the expected ratio of pure noise. It estimates the
    first-order Sobol index from runs of any sampler.

    Args:
        x: A variation, shape (n,). If it has many values, neighbouring values form groups.
        y: A metric, shape (n,).
    """
    n = len(x)
    levels = np.unique(x)
    if len(levels) <= _GROUPS:
        groups = [y[x == value] for value in levels]
    else:
        groups = np.array_split(y[np.argsort(x, kind="stable")], _GROUPS)
    between = sum(len(group) * (group.mean() - y.mean()) ** 2 for group in groups)
    ratio = between / np.sum((y - y.mean()) ** 2)
    return float(max(0.0, 1.0 - (1.0 - ratio) * (n - 1) / (n - len(groups))))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return float("nan")
    return float(value)
