"""Commands that repeat one run of a study."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.experiment.config.key_path import quote_toml

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


def toml_value(value: Any) -> str:
    """Return a value as TOML in one line, with numbers that can be read back exactly."""
    if isinstance(value, Mapping):
        pairs = (f"{_key(name)} = {toml_value(inner)}" for name, inner in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, float):
        return repr(value)
    return quote_toml(value) if isinstance(value, str) else json_text(value)


def _key(name: str) -> str:
    bare = name.replace("_", "").replace("-", "").isalnum() and name.isascii()
    return name if bare else quote_toml(name)
