"""Random force distribution problems, and their optima by enumeration."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
from scipy.optimize import linprog

Array = np.ndarray

LOW, HIGH = 10.0, 100.0


def stacked(seed: int, poses: int, n: int, m: int, size: float = 1.0) -> tuple[Array, Array]:
    """Return L and tau of several poses; some are infeasible if `size` is large."""
    rng = np.random.default_rng(seed)
    L = rng.normal(size=(poses, m, n)) * 0.1
    centre = -np.einsum("pmn,m->pn", L, np.full(m, 0.5 * (LOW + HIGH)))
    return L, centre + size * rng.normal(size=(poses, n))


def feasible(L: Array, tau: Array, low: float = LOW, high: float = HIGH) -> bool:
    """Return whether forces exist, by a linear programme of SciPy."""
    status = linprog(np.zeros(len(L)), A_eq=-L.T, b_eq=tau, bounds=(low, high)).status
    return bool(status == 0)


def vertices(L: Array, tau: Array, low: float = LOW, high: float = HIGH) -> Array:
    """Return all vertices of the feasible set: all choices of m - n forces at their bounds."""
    m, n = L.shape
    found = []
    for at_bound in combinations(range(m), m - n):
        free = [k for k in range(m) if k not in at_bound]
        for values in product((low, high), repeat=m - n):
            f = np.zeros(m)
            f[list(at_bound)] = values
            f[free] = np.linalg.solve(-L[free].T, tau + L.T @ f)
            if (f >= low - 1e-9).all() and (f <= high + 1e-9).all():
                found.append(f)
    return np.array(found).reshape(-1, m)


def least_norm(L: Array, tau: Array, target: Array, low: float = LOW, high: float = HIGH) -> Array:
    """Return f that minimises |f - target|, by all choices of forces at their bounds."""
    m, n = L.shape
    best, forces = np.inf, np.full(m, np.nan)
    for at in product((None, low, high), repeat=m):
        free = np.array([value is None for value in at])
        f = np.array([0.0 if value is None else value for value in at])
        if free.sum() < n:
            continue
        rest = tau + L.T @ f + L[free].T @ target[free]
        f[free] = target[free] + np.linalg.lstsq(-L[free].T, rest, rcond=None)[0]
        inside = (f >= low - 1e-9).all() and (f <= high + 1e-9).all()
        if inside and np.abs(tau + L.T @ f).max() < 1e-9 and np.sum((f - target) ** 2) < best:
            best, forces = float(np.sum((f - target) ** 2)), f
    return forces
