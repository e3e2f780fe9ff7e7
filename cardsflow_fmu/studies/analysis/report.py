"""Report of a study as a self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from cardsflow_fmu.results.report.html import Markup, page, table
from cardsflow_fmu.studies.definition.metrics import split_metric
from cardsflow_fmu.studies.definition.rerun_command import metrics_command
from cardsflow_fmu.studies.definition.study import Study

from .plots import heat_map, histogram, search_history, sensitivity_bars
from .statistics import Collected

_MAX_VALUE = 1e100  # maximum value in figures
_SHOWN = ("count", "min", "p05", "median", "mean", "p95", "max", "deviation")


def report_page(
    study: Study,
    summary: Mapping[str, Any],
    collected: Collected,
    units: Mapping[str, str],
    history: Mapping[str, Sequence[float]] | None = None,
) -> str:
    """Return the report as HTML."""
    parts = [
        f"<h1>{escape(study.name)}</h1>",
        _opening(study, summary),
        *_best(study, summary, units, history),
        *_best_by_metric(study, summary, units),
        *_heat_maps(study, collected, units),
        *_distributions(summary, units),
        *_histograms(collected, units),
        *_worst(study, summary, units),
        *_sensitivity(summary),
        *_failures(collected),
    ]
    return page(study.name, *parts)


def _opening(study: Study, summary: Mapping[str, Any]) -> str:
    varied = ", ".join(escape(v.name) for v in study.variations) or "nothing"
    return (
        f"<p>{summary['runs']} runs of <code>{escape(str(study.experiment))}</code>, "
        f"{summary['failed']} failed; {study.compute}, seed {study.seed}. "
        f"Varied: {varied}.</p>"
    )


def _best(
    study: Study,
    summary: Mapping[str, Any],
    units: Mapping[str, str],
    history: Mapping[str, Sequence[float]] | None,
) -> Iterable[str]:
    best = summary.get("best")
    if study.optimise is None or history is None:
        return
    objective = study.optimise.objective
    unit = units[objective]
    yield "<h2>Optimum</h2>"
    if best is None:
        yield "<p>No run satisfies the constraints.</p>"
    else:
        yield f"<p>{escape(objective)} {best['objective']:.6g} {escape(unit)}</p>"
        yield table(("setting", "value"), best["settings"].items())
        yield f"<p><code>{escape(best['command'])}</code></p>"
    yield search_history(objective, unit, history)


def _best_by_metric(
    study: Study, summary: Mapping[str, Any], units: Mapping[str, str]
) -> Iterable[str]:
    rows = [
        (
            f"{name} [{units[name] or '-'}]",
            case["value"],
            case["run"],
            ", ".join(f"{key} = {_text(value)}" for key, value in case["settings"].items()),
            _commands(metrics_command(study, case["hash"]), case["command"]),
        )
        for name, case in summary["best_by_metric"].items()
    ]
    if rows:
        yield "<h2>Best runs</h2>"
        yield table(("metric", "value", "run", "settings", "command"), rows)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _heat_maps(study: Study, collected: Collected, units: Mapping[str, str]) -> Iterable[str]:
    """Yield a figure of every metric if the study has two numeric variations."""
    names = [v.name for v in study.variations if v.has_range]
    if len(names) != 2 or not all(np.isfinite(collected.inputs[name]).all() for name in names):
        return
    x, y = (collected.inputs[name] for name in names)
    maps = []
    for name, values in collected.metrics.items():
        values = np.where(np.abs(values) < _MAX_VALUE, values, np.nan)
        finite = values[np.isfinite(values)]
        if split_metric(name)[1] is None and finite.size > 1 and np.ptp(finite) > 0:
            maps.append(heat_map((names[0], names[1]), x, y, (name, units[name]), values))
    if maps:
        heading = f"Over {names[0]} and {names[1]}"
        yield f"<h2>{escape(heading)}</h2>"
        yield "<p>Mean values of runs with equal variations; grey if all runs failed.</p>"
    yield from maps


def _distributions(summary: Mapping[str, Any], units: Mapping[str, str]) -> Iterable[str]:
    rows = [
        (f"{name} [{units[name] or '-'}]", *(numbers[key] for key in _SHOWN))
        for name, numbers in summary["metrics"].items()
    ]
    if rows:
        yield "<h2>Distributions</h2>"
        yield table(("metric", *_SHOWN), rows)


def _histograms(collected: Collected, units: Mapping[str, str]) -> Iterable[str]:
    for name, values in collected.metrics.items():
        finite = values[np.abs(values) < _MAX_VALUE]
        if split_metric(name)[1] is None and finite.size > 1 and np.ptp(finite) > 0:
            yield histogram(name, units[name], finite)


def _worst(study: Study, summary: Mapping[str, Any], units: Mapping[str, str]) -> Iterable[str]:
    if summary["worst"]:
        yield "<h2>Worst cases</h2>"
        yield (
            "<p>Each command prints the metrics of a run. Open it to see the command that writes "
            "the files of the run.</p>"
        )
    for name, cases in summary["worst"].items():
        yield f"<h3>{escape(name)}</h3>"
        rows = [
            (
                c["run"],
                f"{c['value']:.6g} {units[name]}",
                _commands(metrics_command(study, c["hash"]), c["command"]),
            )
            for c in cases
        ]
        yield table(("run", "value", "command"), rows)


def _sensitivity(summary: Mapping[str, Any]) -> Iterable[str]:
    influences = {n: p for n, p in summary["sensitivity"].items() if split_metric(n)[1] is None}
    if influences:
        kinds = next(iter(next(iter(influences.values())).values()))
        measures = "Sobol indices" if "first" in kinds else "rank correlations, shares of variance"
        yield f"<h2>Sensitivity: {measures}</h2>"
    for name, parts in influences.items():
        yield sensitivity_bars(name, parts)


def _failures(collected: Collected) -> Iterable[str]:
    if collected.failures:
        yield "<h2>Failed runs</h2>"
        yield table(("error", "runs"), collected.failures.items())


def _commands(first: str, second: str) -> Markup:
    """Return two commands as HTML; the second is visible after a click on the first."""
    summary = f"<summary><code>{escape(first)}</code></summary>"
    return Markup(f"<details>{summary}<code>{escape(second)}</code></details>")
