"""Summary of a study: distributions, worst cases and sensitivities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.results.summary import versions
from cardsflow_fmu.studies.definition.rerun_command import rerun_command
from cardsflow_fmu.studies.definition.study import Study

from .statistics import Collected, distributions, rank_runs, sensitivities
from .table import Rows

_WORST = 5


def summary_text(summary: Mapping[str, Any]) -> str:
    """Return the summary of a study as JSON, with null for numbers that are not finite."""
    return json_text(summary, indent=1) + "\n"


def study_summary(study: Study, collected: Collected, rows: Rows) -> dict[str, Any]:
    """Return the content of summary.json."""
    ranked = {} if study.optimise else rank_runs(collected)  # a search also evaluates bad robots
    worst = {name: rows_[:_WORST] for name, rows_ in ranked.items()}
    best = {name: rows_[-1] for name, rows_ in ranked.items()}
    chosen = {row for rows_ in worst.values() for row in rows_} | set(best.values())
    runs = {row: run for row, (run, _) in enumerate(rows()) if row in chosen}

    def case(name: str, row: int) -> dict[str, Any]:
        run = runs[row]
        return {
            "run": run.index,
            "hash": run.hash,
            "value": float(collected.metrics[name][row]),
            "settings": dict(run.settings),
            "command": rerun_command(study, run),
        }

    complete = len(collected.overheads)
    return {
        "study": study.name,
        "experiment": str(study.experiment),
        "compute": study.compute,
        "seed": study.seed,
        "runs": len(collected.hashes),
        "complete": complete,
        "failed": len(collected.hashes) - complete,
        "failures": collected.failures,
        "overhead_s": float(np.median(collected.overheads or [0.0])),
        "metrics": distributions(collected),
        "worst": {name: [case(name, row) for row in rows_] for name, rows_ in worst.items()},
        "best_by_metric": {name: case(name, row) for name, row in best.items()},
        "sensitivity": sensitivities(study, collected),
        "versions": versions(),
    }
