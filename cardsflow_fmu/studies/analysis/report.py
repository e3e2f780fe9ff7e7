"""The report of a study: one page that opens offline."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from cardsflow_fmu.studies.definition.metrics import parted
from cardsflow_fmu.studies.definition.rerun_command import only_command
from cardsflow_fmu.studies.definition.study import Study

from .plots import histogram, search_history, sensitivity_bars
from .statistics import Collected

_STYLE = """body{font:14px/1.45 sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse}
td,th{padding:.15em .7em;border-bottom:1px solid #ddd;text-align:right}
td:first-child,th:first-child,td.text{text-align:left}code{font-size:12px;word-break:break-all}
td code{text-align:left}td{white-space:nowrap}details code{white-space:normal}
summary{text-align:left}"""

_LARGEST = 1e100  # beyond this nothing is drawn: its axes could not hold it
_SHOWN = ("count", "min", "p05", "median", "mean", "p95", "max", "deviation")


def report_page(
    study: Study,
    summary: Mapping[str, Any],
    collected: Collected,
    units: Mapping[str, str],
    history: Mapping[str, Sequence[float]] | None = None,
) -> str:
    """The page, as HTML.

    Args:
        study: The study.
        summary: What its summary.json holds.
        collected: The numbers of its runs.
        units: Of the metrics.
        history: Of an optimisation, see `plots.search_history`.
    """
    parts = [
        f"<h1>{escape(study.name)}</h1>",
        _opening(study, summary),
        *_best(study, summary, units, history),
        *_distributions(summary, units),
        *_histograms(collected, units),
        *_worst(study, summary, units),
        *_sensitivity(summary),
        *_failures(collected),
    ]
    body = "\n".join(parts)
    return (
        "<!DOCTYPE html>\n"
        f'<html lang="en"><head><meta charset="utf-8"><title>{escape(study.name)}</title>'
        f"<style>{_STYLE}</style></head><body>\n{body}\n</body></html>\n"
    )


def _opening(study: Study, summary: Mapping[str, Any]) -> str:
    varied = ", ".join(escape(v.name) for v in study.variations) or "nothing"
    return (
        f"<p>{summary['runs']} runs of <code>{escape(str(study.experiment))}</code>, "
        f"{summary['failed']} failed; engine {study.engine}, seed {study.seed}. "
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
        yield "<p>No run meets the constraints.</p>"
    else:
        yield f"<p>{escape(objective)} {best['objective']:.6g} {escape(unit)}</p>"
        yield _table(("setting", "value"), [(k, _cell(v)) for k, v in best["settings"].items()])
        yield f"<p><code>{escape(best['command'])}</code></p>"
    yield search_history(objective, unit, history)


def _distributions(summary: Mapping[str, Any], units: Mapping[str, str]) -> Iterable[str]:
    rows = [
        (f"{name} [{units[name] or '-'}]", *(_cell(numbers[key]) for key in _SHOWN))
        for name, numbers in summary["metrics"].items()
    ]
    if rows:
        yield "<h2>Distributions</h2>"
        yield _table(("metric", *_SHOWN), rows)


def _histograms(collected: Collected, units: Mapping[str, str]) -> Iterable[str]:
    for name, values in collected.metrics.items():
        there = values[np.abs(values) < _LARGEST]
        if parted(name)[1] is None and there.size > 1 and np.ptp(there) > 0:
            yield histogram(name, units[name], there)


def _worst(study: Study, summary: Mapping[str, Any], units: Mapping[str, str]) -> Iterable[str]:
    if summary["worst"]:
        yield "<h2>Worst cases</h2>"
        yield "<p>A command prints the run's metrics; the one behind it writes its files.</p>"
    for name, cases in summary["worst"].items():
        yield f"<h3>{escape(name)}</h3>"
        rows = [
            (
                str(c["run"]),
                f"{c['value']:.6g} {units[name]}",
                f"{only_command(study, c['hash'])}\n{c['command']}",
            )
            for c in cases
        ]
        yield _table(("run", "value", "again"), rows)


def _sensitivity(summary: Mapping[str, Any]) -> Iterable[str]:
    found = {n: p for n, p in summary["sensitivity"].items() if parted(n)[1] is None}
    if found:
        kinds = next(iter(next(iter(found.values())).values()))
        what = "Sobol's indices" if "first" in kinds else "rank correlations, shares of variance"
        yield f"<h2>Sensitivity: {what}</h2>"
    for name, parts in found.items():
        yield sensitivity_bars(name, parts)


def _failures(collected: Collected) -> Iterable[str]:
    if collected.failures:
        yield "<h2>Failed runs</h2>"
        rows = [(error, str(count)) for error, count in collected.failures.items()]
        yield _table(("error", "runs"), rows)


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _table(names: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{_escaped(cell)}</td>" for cell in row) + "</tr>\n" for row in rows
    )
    return f"<table><tr>{head}</tr>\n{body}</table>"


def _escaped(cell: str) -> str:
    """A cell; of two commands the second is folded away behind the first."""
    if not cell.startswith("cardsflow "):
        return escape(cell)
    first, _, second = cell.partition("\n")
    code = f"<code>{escape(first)}</code>"
    if not second:
        return code
    return f"<details><summary>{code}</summary><code>{escape(second)}</code></details>"
