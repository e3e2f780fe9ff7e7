"""Linear constraints between nodes: limits of rates of controls, and periodic motions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix, identity, kron, vstack

from controllers.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class LinearConstraint:
    """Constraint low <= X x + U u + t T <= high.

    Attributes:
        name: Name for messages.
        rows: Names of the r rows.
        nodes: Node of each row, for messages, shape (r,).
        states: X, for the states x0, x1, ..., shape (r, (N + 1) nx).
        controls: U, for the controls u0, u1, ..., shape (r, N nu).
        duration: t, shape (r,).
        low, high: Bounds, shape (r,); all rows are equalities, or none.
        in_stages: Whether each row contains only variables of adjacent intervals, and T.
    """

    name: str
    rows: tuple[str, ...]
    nodes: IntArray
    states: csr_matrix
    controls: csr_matrix
    duration: FloatArray
    low: FloatArray
    high: FloatArray
    in_stages: bool = True

    def value(self, x: FloatArray, u: FloatArray, T: float) -> FloatArray:
        """Return the values of the rows, shape (r,)."""
        values: FloatArray = self.states @ x.ravel() + self.controls @ u.ravel() + self.duration * T
        return values


def limited_rates(
    limits: FloatArray, names: tuple[str, ...], intervals: int, nx: int
) -> LinearConstraint:
    """Return the constraint |u_k+1 - u_k| N / limits <= T.

    Args:
        limits: Largest rates of the controls, shape (nu,); positive; infinite for none.
        names: Names of the controls.
        intervals: Number N of intervals.
        nx: Number of states.
    """
    chosen, nu = np.flatnonzero(np.isfinite(limits)), len(limits)
    steps = csr_matrix(np.diff(np.eye(intervals), axis=0))
    unit = np.eye(nu)[chosen] * (intervals / limits[chosen, None])  # rows in seconds
    differences = kron(steps, csr_matrix(unit), format="csr")
    count = differences.shape[0]
    nodes = np.repeat(np.arange(1, intervals), len(chosen))
    return LinearConstraint(
        "f_rate_max",
        tuple(names[k] for k in chosen) * (2 * (intervals - 1)),
        np.tile(nodes, 2),
        csr_matrix((2 * count, (intervals + 1) * nx)),
        csr_matrix(vstack([differences, -differences])),
        -np.ones(2 * count),
        np.full(2 * count, -np.inf),
        np.zeros(2 * count),
    )


def periodic(
    chosen: IntArray, advance: FloatArray, names: tuple[str, ...], shape: tuple[int, int], nu: int
) -> LinearConstraint:
    """Return the constraint x_N = x_0 + advance for some states.

    Args:
        chosen: Indices of the states, shape (r,).
        advance: Changes of these states, shape (r,).
        names: Names of all states.
        shape: Numbers of nodes and of states, (N + 1, nx).
        nu: Number of controls.
    """
    count, nx = shape
    unit = csr_matrix(identity(nx))[chosen]
    between = kron(csr_matrix([[-1.0, *np.zeros(count - 2), 1.0]]), unit, format="csr")
    return LinearConstraint(
        "periodic",
        tuple(names[k] for k in chosen),
        np.full(len(chosen), count - 1),
        between,
        csr_matrix((len(chosen), (count - 1) * nu)),
        np.zeros(len(chosen)),
        advance,
        advance,
        in_stages=False,
    )
