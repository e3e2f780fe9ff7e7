"""Optimisers in the unit cube: differential evolution of SciPy, and CMA-ES."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from addin_sdfusion.robot import InputError
from cardsflow_fmu.studies.definition.sampling import sample
from cardsflow_fmu.studies.definition.tables import Optimise
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.extras import install

Evaluate = Callable[[Sequence[FloatArray]], list[float]]
"""Function that returns the costs of a generation of points in the unit cube, in order."""

_SPREAD = 0.3  # initial standard deviation of CMA-ES in the unit cube


def search(settings: Optimise, dimensions: int, seed: int, evaluate: Evaluate) -> None:
    """Minimise the cost, generation by generation; `evaluate` stores the results.

    Args:
        settings: Algorithm and sizes.
        dimensions: Number of dimensions of the unit cube.
        seed: Seed of the search; equal seeds result in equal searches.
        evaluate: Function that returns the costs of a generation.
    """
    methods = {"differential_evolution": _differential_evolution, "cma_es": _cma_es}
    methods[settings.method](settings, dimensions, seed, evaluate)


def _differential_evolution(
    settings: Optimise, dimensions: int, seed: int, evaluate: Evaluate
) -> None:
    def generation(function: Any, points: Iterable[FloatArray]) -> list[float]:
        return evaluate(list(points))

    def single(point: FloatArray) -> float:
        return evaluate([point])[0]

    differential_evolution(
        single,
        Bounds([0.0] * dimensions, [1.0] * dimensions),
        init=sample("sobol", dimensions, settings.population, seed),
        maxiter=settings.generations - 1,
        updating="deferred",
        workers=generation,
        polish=False,
        tol=1e-6,
        seed=np.random.default_rng(seed),
    )


def _cma_es(settings: Optimise, dimensions: int, seed: int, evaluate: Evaluate) -> None:
    try:
        from cmaes import CMA
    except ImportError:
        problem = f"'cma_es' requires cmaes: {install('optimise')}"
        raise InputError(problem, key="optimise.method") from None
    optimiser = CMA(
        mean=np.full(dimensions, 0.5),
        sigma=_SPREAD,
        bounds=np.array([[0.0, 1.0]] * dimensions),
        seed=seed,
        population_size=settings.population,
    )
    for _ in range(settings.generations):
        points = [optimiser.ask() for _ in range(optimiser.population_size)]
        optimiser.tell(list(zip(points, evaluate(points), strict=True)))
        if optimiser.should_stop():
            return
