"""From a study to its runs: pure, and the same every time."""

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

_POINTS, _RUNS = 0, 1  # what a seed is spawned for


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a study.

    Attributes:
        index: Its place in the study, from 0.
        values: The value of every variation, by its name.
        settings: The changes to the experiment, by full key.
        hash: Of everything that its results rest on; the name of its file.
    """

    index: int
    values: Mapping[str, Any]
    settings: Mapping[str, Any]
    hash: str


def expand(study: Study, fingerprint: str) -> Iterator[Run]:
    """The runs of a study, in order.

    Args:
        study: A sampling.
        fingerprint: Of what all runs have in common; see `fingerprint`.
    """
    for index, values in enumerate(_rows(study)):
        yield make_run(study, fingerprint, index, values)


def run_count(study: Study) -> int:
    """Return how many runs a sampling has."""
    sizes = [len(v.listed) for v in study.variations if v.is_listed]
    if study.sampler == "grid":
        return int(np.prod(sizes, dtype=np.int64))
    if study.sampler == "list":
        return max(sizes, default=1)
    assert study.count is not None
    if study.sampler == "sensitivity":
        return study.count * (len(_searched(study)) + 2)
    return study.count


def make_run(study: Study, fingerprint: str, index: int, values: Sequence[Any]) -> Run:
    """Return a run with its settings and its hash.

    Args:
        study: The study.
        fingerprint: Of what all runs have in common.
        index: Its place.
        values: One a variation; seeds are put in.
    """
    named: dict[str, Any] = {}
    settings: dict[str, Any] = {}
    for variation, value in zip(study.variations, values, strict=True):
        own = run_seed(study.seed, index) if variation.is_seed else value
        named[variation.name] = own
        settings |= variation.settings(own)
    text = json_text([fingerprint, settings], sort_keys=True)
    return Run(index, named, settings, hashlib.sha256(text.encode()).hexdigest()[:24])


def run_seed(seed: int, index: int) -> int:
    """Return the seed of one run: that of the index-th child that the study's sequence spawns."""
    sequence = np.random.SeedSequence(seed, spawn_key=(_RUNS, index))
    return int(sequence.generate_state(1)[0])


def searched_values(variations: Sequence[Variation], u: Sequence[float]) -> list[Any]:
    """Return the values at a point of the unit cube of the variations that have a range.

    Args:
        variations: All of the study.
        u: One number from 0 to 1 for each with a range; the others take their only value.
    """
    numbers = iter(u)
    return [v.range.at(next(numbers)) if is_searched(v) else v.range.at(0.0) for v in variations]


def is_searched(variation: Variation) -> bool:
    """Return whether a variation takes a dimension: it has more than one value, and is no seed."""
    return not variation.is_seed and not (variation.is_listed and len(variation.listed) == 1)


def sample(sampler: str, dimensions: int, count: int, seed: int) -> FloatArray:
    """Return points in the unit cube, shape (count, dimensions).

    Args:
        sampler: `sobol`, `latin_hypercube` or `monte_carlo`.
        dimensions: At least 1.
        count: How many.
        seed: Where the random numbers come from.
    """
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_POINTS,)))
    if sampler == "sobol":
        # whole powers of 2 are balanced; the first of them are what the sequence begins with
        power = max(count - 1, 0).bit_length()
        return np.asarray(qmc.Sobol(dimensions, seed=random).random_base2(power)[:count])
    if sampler == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, seed=random).random(count))
    return random.random((count, dimensions))


def _searched(study: Study) -> list[Variation]:
    return [v for v in study.variations if is_searched(v)]


def _rows(study: Study) -> Iterator[Sequence[Any]]:
    """The values of every run, one a variation; those of seeds count for nothing."""
    listed = [v.listed if v.is_listed else (0,) for v in study.variations]
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
    dimensions = len(_searched(study))
    if study.sampler == "sensitivity":
        points = _saltelli(dimensions, study.count, study.seed)
    else:
        points = sample(study.sampler, max(dimensions, 1), study.count, study.seed)
    for point in points:
        yield searched_values(study.variations, point.tolist())


def _saltelli(dimensions: int, count: int, seed: int) -> FloatArray:
    """A, B, and A with one column of B after another: what Sobol's indices need."""
    both = sample("sobol", 2 * max(dimensions, 1), count, seed)
    A, B = both[:, :dimensions], both[:, dimensions : 2 * dimensions]
    blocks = [A, B]
    for j in range(dimensions):
        mixed = A.copy()
        mixed[:, j] = B[:, j]
        blocks.append(mixed)
    return np.concatenate(blocks)
