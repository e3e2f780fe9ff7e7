"""Sampling: the runs of a study, which are reproducible."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import qmc

from addin_sdfusion.robot.json_text import json_text
from cardsflow_fmu.utils.arrays import FloatArray

from .study import Study
from .variations import Variation

_POINTS, _RUNS = 0, 1  # spawn keys of the seed sequences for points and runs


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a study.

    Attributes:
        index: Index in the study, from 0.
        values: Value of every variation, by name.
        settings: Changes of the experiment, by full key.
        hash: Hash of all inputs of the run; also the name of its file.
    """

    index: int
    values: Mapping[str, Any]
    settings: Mapping[str, Any]
    hash: str


def expand(study: Study, fingerprint: str) -> Iterator[Run]:
    """Yield the runs of a study, in order."""
    for index, values in enumerate(_rows(study)):
        yield make_run(study, fingerprint, index, values)


def run_count(study: Study) -> int:
    """Return the number of runs of a study with a sampler."""
    sizes = [len(v.range.values) for v in study.variations if v.is_listed]
    if study.sampler == "grid":
        return int(np.prod(sizes, dtype=np.int64))
    if study.sampler == "list":
        return max(sizes, default=1)
    assert study.count is not None
    if study.sampler == "sensitivity":
        return study.count * (len(_with_range(study)) + 2)
    return study.count


def make_run(study: Study, fingerprint: str, index: int, values: Sequence[Any]) -> Run:
    """Return a run with its settings and its hash; seeds are replaced by the seed of the run."""
    named: dict[str, Any] = {}
    settings: dict[str, Any] = {}
    for variation, value in zip(study.variations, values, strict=True):
        used = run_seed(study.seed, index) if variation.is_seed else value
        named[variation.name] = used
        settings |= variation.settings(used)
    text = json_text([fingerprint, settings], sort_keys=True)
    return Run(index, named, settings, hashlib.sha256(text.encode()).hexdigest()[:24])


def run_seed(seed: int, index: int) -> int:
    """Return the seed of one run, from the child sequence with this index."""
    sequence = np.random.SeedSequence(seed, spawn_key=(_RUNS, index))
    return int(sequence.generate_state(1)[0])


def values_at(variations: Sequence[Variation], u: Sequence[float]) -> list[Any]:
    """Return the values of all variations at a point of the unit cube.

    Args:
        variations: All variations of the study.
        u: One number from 0 to 1 for each variation with a range; the others are constant.
    """
    numbers = iter(u)
    return [v.range.at(next(numbers)) if v.has_range else v.range.at(0.0) for v in variations]


def sample(sampler: str, dimensions: int, count: int, seed: int) -> FloatArray:
    """Return points in the unit cube, shape (count, dimensions).

    Args:
        sampler: `sobol`, `latin_hypercube` or `monte_carlo`.
        dimensions: Number of dimensions, at least 1.
        count: Number of points.
        seed: Seed of the random numbers.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_POINTS,)))
    if sampler == "sobol":
        # only powers of 2 are balanced; the sequence begins with the same points for any count
        power = max(count - 1, 0).bit_length()
        return np.asarray(qmc.Sobol(dimensions, seed=random).random_base2(power)[:count])
    if sampler == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, seed=random).random(count))
    return random.random((count, dimensions))


def _with_range(study: Study) -> list[Variation]:
    return [v for v in study.variations if v.has_range]


def _rows(study: Study) -> Iterator[Sequence[Any]]:
    """Yield the values of all variations for every run; the values of seeds are not used."""
    listed = [v.range.values if v.is_listed else (0,) for v in study.variations]
    if study.sampler == "grid":
        yield from itertools.product(*listed)
        return
    if study.sampler == "list":
        size = run_count(study)
        yield from zip(*([*row] * (size if len(row) == 1 else 1) for row in listed), strict=True)
        if not listed:
            yield ()
        return
    assert study.count is not None
    dimensions = len(_with_range(study))
    if study.sampler == "sensitivity":
        points = _saltelli(dimensions, study.count, study.seed)
    else:
        points = sample(study.sampler, max(dimensions, 1), study.count, study.seed)
    for point in points:
        yield values_at(study.variations, point.tolist())


def _saltelli(dimensions: int, count: int, seed: int) -> FloatArray:
    """Return Saltelli's points A, B, and A with column j of B for each j, for Sobol indices."""
    both = sample("sobol", 2 * max(dimensions, 1), count, seed)
    A, B = both[:, :dimensions], both[:, dimensions : 2 * dimensions]
    blocks = [A, B]
    for j in range(dimensions):
        mixed = A.copy()
        mixed[:, j] = B[:, j]
        blocks.append(mixed)
    return np.concatenate(blocks)
