"""Commands that repeat one run of a study."""

from __future__ import annotations

import shlex

from cardsflow_fmu.experiment.config.key_path import toml_value

from .sampling import Run
from .study import Study


def rerun_command(study: Study, run: Run) -> str:
    """Return the `cardsflow run` command with all settings of a run."""
    words = ["cardsflow", "run", str(study.experiment)]
    for key, value in {**study.settings, **run.settings}.items():
        words += ["--set", f"{key}={toml_value(value)}"]
    return shlex.join([*words, "-o", f"run_{run.hash[:8]}"])


def metrics_command(study: Study, run_hash: str) -> str:
    """Return the `cardsflow study` command that repeats one run and prints its metrics."""
    return shlex.join(["cardsflow", "study", str(study.file), "--only", run_hash[:8]])
