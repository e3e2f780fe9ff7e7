"""The reader of study.toml."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError
from cardsflow_fmu.experiment.config.file import read_settings
from cardsflow_fmu.experiment.config.key_path import join_path, split_path
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.names import robot_names
from cardsflow_fmu.utils.extras import install

from .metrics import DEFAULT_METRICS, expand_wildcards
from .path_check import PathCheck
from .tables import MAX_RUNS, Box, Sampler, StudyTables
from .variation_reader import read_variations, require_free_names
from .variations import Variation

STUDY_FILE = Path("study.toml")
"""What a study is called that has a folder to itself."""

_MAX_POSES = 100_000


def read_study(path: Path) -> dict[str, Any]:
    """Read and check a study.

    Args:
        path: A study.toml, or the folder that holds one.

    Returns:
        The attributes of a `Study`.

    Raises:
        InputError: Something in it, or in its experiment, is wrong; file and key are named.
    """
    file = path / STUDY_FILE if path.is_dir() else path
    data = read_settings(file)
    context = Context(file)
    if "engine" in data:
        raise context.error("engine", "is no longer a key: set compute and coupling")
    tables = StudyTables.read(data, context)
    engine = {"run.compute": tables.compute, "run.coupling": tables.coupling}
    settings = engine | _settings(tables.settings, context)
    check = PathCheck(tables.experiment, settings)
    base = check.base  # what is wrong with the experiment itself comes first
    variations = tuple(read_variations(tables.vary, check, context))
    if tables.optimise is not None and not _can_search(variations):
        what = "needs variations with a range to search, and no seeds"
        raise context.error("optimise.method", what)
    sampler, count = _sampling(tables, variations, context)
    metrics = _metrics(tables, base, context)
    require_free_names(variations, metrics, context)
    _require_parquet(tables, context)
    usual = "results" if file.name == STUDY_FILE.name else f"results/{file.stem}"
    return {
        "file": file,
        "experiment": tables.experiment,
        "settings": settings,
        "seed": tables.seed,
        "variations": variations,
        "sampler": sampler,
        "count": count,
        "metrics": metrics,
        "box": _box(data.get("workspace"), base, context),
        "optimise": tables.optimise,
        "output": tables.output or file.parent / usual,
        "tables": tuple(dict.fromkeys(tables.tables)),
    }


def _settings(given: Mapping[str, Any], context: Context) -> dict[str, Any]:
    """Changes to the experiment that all runs share: full keys, or tables in tables."""
    settings: dict[str, Any] = {}
    for key, value in given.items():
        try:
            settings |= _leaves(split_path(key), value)
        except InputError as error:
            raise context.error("settings", f"{key!r} {error.what}") from None
    return settings


def _leaves(path: list[str], value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {join_path(path): value}
    return {k: v for name, inner in value.items() for k, v in _leaves([*path, name], inner).items()}


def _can_search(variations: Sequence[Variation]) -> bool:
    """Return whether something is varied over a range, and nothing by seeds."""
    held = [v.is_listed and len(v.listed) == 1 for v in variations]
    return not all(held) and not any(v.is_seed for v in variations)


def _sampling(
    tables: StudyTables, variations: Sequence[Variation], context: Context
) -> tuple[Sampler, int | None]:
    """How the variations are combined, and how often."""
    drawn = [v.name for v in variations if not v.is_listed and not v.is_seed]
    sampler = tables.sampler or ("monte_carlo" if drawn else "grid")
    count = tables.count
    if tables.optimise is not None:
        if tables.sampler is not None or count is not None:
            raise context.error("sampler", "an optimisation samples by itself; leave it out")
        return sampler, None
    if sampler in ("grid", "list"):
        if drawn:
            raise context.error("sampler", f"{sampler!r} needs `values` or `grid` for {drawn[0]}")
        if count is not None:
            raise context.error("count", f"{sampler!r} has as many runs as its values make")
        sizes = [len(v.listed) for v in variations if v.is_listed]
        if sampler == "list" and len(set(sizes)) > 1:
            raise context.error("vary", f"a list needs equally many values everywhere, not {sizes}")
        if sampler == "grid" and math.prod(sizes) > MAX_RUNS:
            raise context.error("vary", f"a grid of {math.prod(sizes)} runs; at most {MAX_RUNS}")
        return sampler, None
    if count is None or not 1 <= count <= MAX_RUNS:
        raise context.error("count", f"must be 1 to {MAX_RUNS} for {sampler!r}, not {count}")
    if sampler == "sensitivity" and count & (count - 1):
        raise context.error("count", f"must be a power of 2 for {sampler!r}, not {count}")
    if not variations:
        raise context.error("vary", "missing: what is varied")
    return sampler, count


def _metrics(tables: StudyTables, base: Experiment, context: Context) -> tuple[str, ...]:
    """Return the metrics that are asked for, and those that an optimisation needs."""
    names = list(DEFAULT_METRICS if tables.metrics is None else tables.metrics)
    if (search := tables.optimise) is not None:
        names += [search.objective, *(c.metric for c in search.constraints)]
    with context.at("metrics"):
        return expand_wildcards(names, base.robot)


def _require_parquet(tables: StudyTables, context: Context) -> None:
    if "parquet" in tables.tables and importlib.util.find_spec("pyarrow") is None:
        raise context.error("tables", f"parquet needs pyarrow: {install('parquet')}")


def _box(data: Mapping[str, Any] | None, base: Experiment, context: Context) -> Box | None:
    """Joint positions of the workspace."""
    if not data:
        return None
    coordinates = base.robot.coordinates
    limits = {
        "lower": tuple(c.lower for c in coordinates),
        "upper": tuple(c.upper for c in coordinates),
    }
    box = Box.read(
        data, replace(context, names=robot_names(base.robot), defaults=limits), "workspace"
    )
    if any(a > b for a, b in zip(box.lower, box.upper, strict=True)):
        raise context.error("workspace.lower", "must not be above upper")
    if box.points < 1 or box.points ** len(coordinates) > _MAX_POSES:
        what = f"{box.points} along each axis are too few or too many poses"
        raise context.error("workspace.points", what)
    return box
