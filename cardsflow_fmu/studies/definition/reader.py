"""Reader for study.toml."""

from __future__ import annotations

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
from cardsflow_fmu.experiment.settings.robots import robot_names

from .metrics import DEFAULT_METRICS, expand_wildcards
from .path_check import PathCheck
from .tables import MAX_RUNS, Box, Sampler, StudyTables
from .variation_reader import read_variations, require_unique_columns
from .variations import Variation

STUDY_FILE = Path("study.toml")
"""Default file name of a study in its folder."""

_MAX_POSES = 100_000


def read_study(path: Path) -> dict[str, Any]:
    """Read and check a study.

    Args:
        path: A study.toml, or its folder.
    """
    file = path / STUDY_FILE if path.is_dir() else path
    data = read_settings(file)
    context = Context(file)
    tables = StudyTables.read(data, context)
    engine = {"run.compute": tables.compute, "run.coupling": "direct"}
    settings = engine | _settings(tables.settings, context)
    check = PathCheck(tables.experiment, settings)
    base = check.base  # report errors of the experiment first
    variations = tuple(read_variations(tables.vary, check, context))
    if tables.optimise is not None and not _can_search(variations):
        problem = "requires variations with a range, and does not support seeds"
        raise context.error("optimise.method", problem)
    sampler, count = _sampling(tables, variations, context)
    metrics = _metrics(tables, base, context)
    require_unique_columns(variations, metrics, context)
    default = "results" if file.name == STUDY_FILE.name else f"results/{file.stem}"
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
        "output": tables.output or file.parent / default,
    }


def _settings(table: Mapping[str, Any], context: Context) -> dict[str, Any]:
    """Return the changes of settings for all runs by full key; tables can be nested."""
    settings: dict[str, Any] = {}
    for key, value in table.items():
        try:
            settings |= _leaves(split_path(key), value)
        except InputError as error:
            raise context.error("settings", f"{key!r} {error.problem}") from None
    return settings


def _leaves(path: list[str], value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {join_path(path): value}
    return {k: v for name, inner in value.items() for k, v in _leaves([*path, name], inner).items()}


def _can_search(variations: Sequence[Variation]) -> bool:
    """Return whether at least one variation has a range, and none is a seed."""
    return any(v.has_range for v in variations) and not any(v.is_seed for v in variations)


def _sampling(
    tables: StudyTables, variations: Sequence[Variation], context: Context
) -> tuple[Sampler, int | None]:
    """Return the sampler and the number of samples."""
    drawn = [v.name for v in variations if not v.is_listed and not v.is_seed]
    sampler = tables.sampler or ("monte_carlo" if drawn else "grid")
    count = tables.count
    if tables.optimise is not None:
        if tables.sampler is not None or count is not None:
            raise context.error("sampler", "is not used by an optimisation; remove it")
        return sampler, None
    if sampler in ("grid", "list"):
        if drawn:
            problem = f"{sampler!r} requires `values` or `grid` for {drawn[0]}"
            raise context.error("sampler", problem)
        if count is not None:
            problem = f"is not used by {sampler!r}, whose values define the number of runs"
            raise context.error("count", f"{problem}; remove it")
        sizes = [len(v.range.values) for v in variations if v.is_listed]
        if sampler == "list" and len(set(sizes)) > 1:
            problem = f"a list requires the same number of values in all variations, not {sizes}"
            raise context.error("vary", problem)
        if sampler == "grid" and math.prod(sizes) > MAX_RUNS:
            problem = f"the grid has {math.prod(sizes)} runs; the maximum is {MAX_RUNS}"
            raise context.error("vary", problem)
        return sampler, None
    if count is None or not 1 <= count <= MAX_RUNS:
        raise context.error("count", f"must be 1 to {MAX_RUNS} for {sampler!r}, not {count}")
    if sampler == "sensitivity" and count & (count - 1):
        raise context.error("count", f"must be a power of 2 for {sampler!r}, not {count}")
    if not variations:
        raise context.error("vary", "is missing; add at least one variation")
    return sampler, count


def _metrics(tables: StudyTables, base: Experiment, context: Context) -> tuple[str, ...]:
    """Return the requested metrics and the metrics that an optimisation requires."""
    names = list(DEFAULT_METRICS if tables.metrics is None else tables.metrics)
    if (search := tables.optimise) is not None:
        names += [search.objective, *(c.metric for c in search.constraints)]
    with context.at("metrics"):
        return expand_wildcards(names, base.robot)


def _box(data: Mapping[str, Any] | None, base: Experiment, context: Context) -> Box | None:
    """Return the joint positions of the workspace, or None for the joint limits."""
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
        problem = f"{box.points} poses per coordinate are too few or too many"
        raise context.error("workspace.points", problem)
    return box
