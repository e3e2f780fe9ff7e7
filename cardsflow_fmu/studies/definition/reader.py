"""Reading study.toml: every error with file and key."""

from __future__ import annotations

import importlib.util
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.files import read_file
from cardsflow_fmu.config.key_path import join_path, split_path
from cardsflow_fmu.config.table import Table
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.signals.roles import ROLES

from .metrics import DEFAULT_METRICS, spelled_out
from .path_check import Trial
from .schema import ENGINES, STUDY, TABLES
from .study import (
    METHODS,
    SAMPLERS,
    STUDY_FILE,
    Box,
    Constraint,
    Engine,
    Method,
    Optimise,
    Sampler,
    Study,
    TableKind,
)
from .variation_reader import read_variations, require_free_names
from .variations import Seed, Variation

_MAX_BYTES = 16 * 2**20
_MOST_RUNS = 1_000_000
_MOST_POSES = 100_000


def read_study(file: Path) -> Study:
    """Read and check a study.

    Args:
        file: A study.toml, or the folder that holds one.

    Raises:
        InputError: Something in it, or in its experiment, is wrong; file and key are named.
    """
    if file.is_dir():
        file /= STUDY_FILE
    try:
        data = tomllib.loads(read_file(file, _MAX_BYTES).decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise InputError("is not UTF-8 text", file=file) from None
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(
            " ".join(str(error).split()) or "is nested too deeply", file=file
        ) from None
    top = Table(data, file, form=STUDY)
    top.refuse_unknown()
    return _study(top)


def _study(top: Table) -> Study:
    path = top.file.parent / top.text("experiment")
    settings = _settings(top)
    trial = Trial(path, settings)
    base = trial.base  # what is wrong with the experiment itself comes first
    rows = top.value("vary", [])
    if not isinstance(rows, list):
        raise top.error("vary", "must be tables, each under [[vary]]")
    variations = tuple(read_variations(top, rows, trial))
    optimise = _optimise(top.table("optimise"), variations) if "optimise" in top else None
    sampler, count = _sampling(top, variations, optimise)
    metrics = _metrics(top, base, optimise)
    require_free_names(top, variations, metrics)
    study = Study(
        file=top.file,
        experiment=path,
        settings=settings,
        engine=_engine(top, base),
        seed=_seed(top),
        variations=variations,
        sampler=sampler,
        count=count,
        metrics=metrics,
        box=_box(top.table("workspace"), base),
        optimise=optimise,
        output=top.file.parent / top.text("output", _results(top.file)),
        tables=_tables(top),
    )
    for key in ("optimise", "workspace"):
        top.value(key, None)
    top.close()
    return study


def _engine(top: Table, base: Experiment) -> Engine:
    """What steps the runs; the loop in C must have all that the experiment has."""
    engine = cast(Engine, top.choice("engine", "engine", ENGINES, "direct"))
    if engine == "native":
        from cardsflow_fmu.native.library import native_models

        try:
            native_models(base, ROLES)
        except InputError as error:
            raise top.error("engine", error.what) from None
    return engine


def _results(file: Path) -> str:
    """The usual folder for results: one a study, where several stand in one folder."""
    return "results" if file.name == STUDY_FILE.name else f"results/{file.stem}"


def _settings(top: Table) -> dict[str, Any]:
    """Changes to the experiment that all runs share: full keys, or tables in tables."""
    table = top.table("settings")
    settings: dict[str, Any] = {}
    for key in table:
        try:
            settings |= _leaves(split_path(key), table.value(key))
        except InputError as error:
            raise top.error("settings", f"{key!r} {error.what}") from None
    return settings


def _leaves(path: list[str], value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        return {join_path(path): value}
    return {k: v for name, inner in value.items() for k, v in _leaves([*path, name], inner).items()}


def _seed(top: Table) -> int:
    seed = top.whole("seed", 0)
    if seed < 0:
        raise top.error("seed", f"must not be negative: {seed}")
    return seed


def _sampling(
    top: Table, variations: Sequence[Variation], optimise: Optimise | None
) -> tuple[Sampler, int | None]:
    """How the variations are combined, and how often."""
    drawn = [v.name for v in variations if not v.is_listed and not v.is_seed]
    usual = "monte_carlo" if drawn else "grid"
    sampler = cast(Sampler, top.choice("sampler", "sampler", SAMPLERS, usual))
    count = top.whole("count") if "count" in top else None
    top.value("count", None)
    if optimise is not None:
        if "sampler" in top or "count" in top:
            raise top.error("sampler", "an optimisation samples by itself; leave it out")
        return sampler, None
    if sampler in ("grid", "list"):
        if drawn:
            raise top.error("sampler", f"{sampler!r} needs `values` or `grid` for {drawn[0]}")
        if count is not None:
            raise top.error("count", f"{sampler!r} has as many runs as its values make")
        _require_sizes(top, variations, sampler)
        return sampler, None
    if count is None or not 1 <= count <= _MOST_RUNS:
        raise top.error("count", f"must be 1 to {_MOST_RUNS} for {sampler!r}, not {count}")
    if sampler == "sensitivity" and count & (count - 1):
        raise top.error("count", f"must be a power of 2 for {sampler!r}, not {count}")
    if not variations:
        raise top.error("vary", "missing: what is varied")
    return sampler, count


def _require_sizes(top: Table, variations: Sequence[Variation], sampler: str) -> None:
    sizes = [len(v.listed) for v in variations if v.is_listed]
    product = 1
    for size in sizes:
        product *= size
    if sampler == "list" and len(set(sizes)) > 1:
        raise top.error("vary", f"a list needs equally many values everywhere, not {sizes}")
    if sampler == "grid" and product > _MOST_RUNS:
        raise top.error("vary", f"a grid of {product} runs; at most {_MOST_RUNS}")


def _metrics(top: Table, base: Experiment, optimise: Optimise | None) -> tuple[str, ...]:
    """The metrics that are asked for, and those that an optimisation needs."""
    names = top.value("metrics", list(DEFAULT_METRICS))
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise top.error("metrics", "must be a list of at least one name")
    if optimise is not None:
        names = [*names, optimise.objective, *(c.metric for c in optimise.constraints)]
    try:
        return spelled_out(names, base.robot)
    except InputError as error:
        raise InputError(error.what, file=top.file, key="metrics") from None


def _box(table: Table, base: Experiment) -> Box | None:
    """Joint positions of the workspace."""
    if table.is_empty:
        return None
    coordinates = base.robot.coordinates
    names = [c.name for c in coordinates]
    box = Box(
        table.by_name("lower", "coordinate", names, [c.lower for c in coordinates]),
        table.by_name("upper", "coordinate", names, [c.upper for c in coordinates]),
        table.whole("points", 5),
    )
    table.close()
    if any(a > b for a, b in zip(box.lower, box.upper, strict=True)):
        raise table.error("lower", "must not be above upper")
    if box.points < 1 or box.points ** len(names) > _MOST_POSES:
        raise table.error("points", f"{box.points} along each axis are too few or too many poses")
    return box


def _optimise(table: Table, variations: Sequence[Variation]) -> Optimise:
    rows = table.value("constraints", [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise table.error("constraints", "must be a list of tables")
    settings = Optimise(
        method=cast(Method, table.choice("method", "method", METHODS, METHODS[0])),
        objective=table.text("objective"),
        maximise=table.flag("maximise", False),
        population=table.whole("population", 16),
        generations=table.whole("generations", 30),
        seeds=_seeds(table),
        constraints=tuple(
            _constraint(table.element("constraints", k, row)) for k, row in enumerate(rows)
        ),
    )
    table.close()
    if settings.population < 5:
        raise table.error("population", f"must be at least 5, not {settings.population}")
    if settings.generations < 1:
        raise table.error("generations", f"must be at least 1, not {settings.generations}")
    if settings.most_runs > _MOST_RUNS:
        raise table.error("generations", f"{settings.most_runs} runs; at most {_MOST_RUNS}")
    if "*" in settings.objective:
        raise table.error("objective", "must be one metric, without `*`")
    if any(isinstance(v.range, Seed) for v in variations) or all(
        v.is_listed and len(v.listed) == 1 for v in variations
    ):
        raise table.error("method", "needs variations with a range to search, and no seeds")
    return settings


def _seeds(table: Table) -> tuple[int, ...]:
    seeds = table.value("seeds", [0])
    good = isinstance(seeds, list) and seeds and len(set(seeds)) == len(seeds)
    if not good or not all(type(seed) is int and seed >= 0 for seed in seeds):
        raise table.error("seeds", f"must be different whole numbers from 0 on, not {seeds!r}")
    return tuple(seeds)


def _constraint(table: Table) -> Constraint:
    limits = {k: table.number(k) if k in table else None for k in ("at_least", "at_most")}
    metric = table.text("metric")
    for key in limits:
        table.value(key, None)
    table.close()
    if all(limit is None for limit in limits.values()):
        raise table.error("metric", "needs at_least or at_most")
    if "*" in metric:
        raise table.error("metric", "must be one metric, without `*`")
    return Constraint(metric, limits["at_least"], limits["at_most"])


def _tables(top: Table) -> tuple[TableKind, ...]:
    kinds = top.value("tables", ["csv"])
    if not isinstance(kinds, list) or not kinds:
        raise top.error("tables", f"must be a list of {' and '.join(TABLES)}")
    for kind in kinds:
        if kind not in TABLES:
            raise top.unknown("tables", "kind of table", str(kind), TABLES)
    if "parquet" in kinds and importlib.util.find_spec("pyarrow") is None:
        raise top.error("tables", "parquet needs pyarrow: pip install 'cardsflow[parquet]'")
    return tuple(dict.fromkeys(kinds))
