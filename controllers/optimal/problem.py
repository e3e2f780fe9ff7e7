"""Optimal-control problem: dynamics over intervals, bounds, costs, and constraints at nodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from controllers.arrays import FloatArray, IntArray

from .costs import Costs
from .linear import LinearConstraint

NO_PARAMETERS: FloatArray = np.zeros(0)


class IntervalResult(Protocol):
    """Ends of k intervals and their derivatives.

    Attributes:
        ends: States at the ends, shape (k, nx).
        A, B, c: Derivatives by the states at the starts, the controls and the lengths, shapes
            (k, nx, nx), (k, nx, nu), (k, nx).
        D: Derivatives by the parameters, shape (k, nx, np).
    """

    @property
    def ends(self) -> FloatArray: ...  # noqa: D102
    @property
    def A(self) -> FloatArray: ...  # noqa: D102
    @property
    def B(self) -> FloatArray: ...  # noqa: D102
    @property
    def c(self) -> FloatArray: ...  # noqa: D102
    @property
    def D(self) -> FloatArray: ...  # noqa: D102


class IntervalDynamics(Protocol):
    """Motion over intervals with constant controls."""

    def run(
        self,
        x: FloatArray,
        u: FloatArray,
        h: FloatArray,
        derivatives: bool = True,
        parameters: FloatArray = NO_PARAMETERS,
        nodes: IntArray | None = None,
    ) -> IntervalResult | None:
        """Simulate k intervals of lengths h, shape (k,); None if a state diverged.

        Each begins at a node, or is a part of the interval that does (default: 0, 1, ...).
        """


@dataclass(frozen=True)
class Parameters:
    """Free parameters p of the dynamics, constant over time, with the cost sum(w (p - p0)^2).

    Attributes:
        low, high: Bounds, shape (np,).
        nominal: p0, which is also the first guess, shape (np,).
        weights: w, shape (np,).
        names: Names for messages.
    """

    low: FloatArray
    high: FloatArray
    nominal: FloatArray
    weights: FloatArray
    names: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self.low)

    @property
    def scale(self) -> FloatArray:
        """Return the range of each parameter, or its size if the range is infinite."""
        span = self.high - self.low
        size = np.where(self.nominal == 0.0, 1.0, abs(self.nominal))
        return np.where(np.isfinite(span) & (span > 0.0), span, size)

    def cost(self, p: FloatArray) -> float:
        """Return the cost of parameters."""
        return float(self.weights @ (p - self.nominal) ** 2)

    def gradient(self, p: FloatArray) -> FloatArray:
        """Return the gradient of the cost, shape (np,)."""
        return 2.0 * self.weights * (p - self.nominal)


@dataclass(frozen=True)
class NodeConstraint:
    """Constraint low <= g(x) <= high at some nodes, or at points of the intervals after them.

    Attributes:
        name: Name for messages.
        rows: Names of the r rows of g.
        nodes: Indices of the nodes, shape (k,).
        evaluate: Function of states, shape (k, nx), that returns g, shape (k, r), and its
            derivatives, shape (k, r, nx).
        low, high: Bounds, shape (r,); equal bounds are an equality.
        shares: Times after the nodes, relative to an interval, shape (k,); None for the nodes. Then
            no bounds are equal.
    """

    name: str
    rows: tuple[str, ...]
    nodes: IntArray
    evaluate: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    low: FloatArray
    high: FloatArray
    shares: FloatArray | None = None


_NO_FREE_PARAMETERS = Parameters(NO_PARAMETERS, NO_PARAMETERS, NO_PARAMETERS, NO_PARAMETERS, ())


class Iterate(NamedTuple):
    """A motion with `N` intervals that may still violate its constraints.

    Attributes:
        x: States at the nodes, shape (N + 1, nx).
        u: Controls in the intervals, shape (N, nu).
        duration: Duration, in [s].
        parameters: Values of the free parameters, shape (np,).
    """

    x: FloatArray
    u: FloatArray
    duration: float
    parameters: FloatArray = NO_PARAMETERS


@dataclass(frozen=True)
class OptimalProblem:
    """Optimal-control problem with `N` intervals of equal length.

    Attributes:
        dynamics: Motion over intervals.
        x_low, x_high: Bounds of the states at the nodes, shape (N + 1, nx); equal bounds fix a
            state.
        u_low, u_high: Bounds of the controls, shape (N, nu).
        duration: Smallest and largest duration, in [s]; equal for a fixed one.
        costs: The cost.
        constraints: Constraints at nodes.
        state_names, control_names: Names for messages.
        parameters: Free parameters of the dynamics.
        linear: Linear constraints between nodes.
    """

    dynamics: IntervalDynamics
    x_low: FloatArray
    x_high: FloatArray
    u_low: FloatArray
    u_high: FloatArray
    duration: tuple[float, float]
    costs: Costs
    constraints: Sequence[NodeConstraint] = ()
    state_names: tuple[str, ...] = ()
    control_names: tuple[str, ...] = ()
    parameters: Parameters = _NO_FREE_PARAMETERS
    linear: Sequence[LinearConstraint] = ()

    @property
    def intervals(self) -> int:
        """Number of intervals."""
        return len(self.u_low)

    @property
    def is_free_time(self) -> bool:
        """Whether the duration is free."""
        return self.duration[0] < self.duration[1]

    def cost(self, at: Iterate) -> float:
        """Return the cost of an iterate."""
        return self.costs.value(at.x, at.u, at.duration) + self.parameters.cost(at.parameters)

    def run(self, at: Iterate, derivatives: bool = True) -> IntervalResult | None:
        """Simulate all intervals of an iterate; None if a state diverged."""
        lengths = np.full(self.intervals, at.duration / self.intervals)
        return self.dynamics.run(at.x[:-1], at.u, lengths, derivatives, at.parameters)

    def run_inside(
        self, at: Iterate, nodes: IntArray, shares: FloatArray, derivatives: bool = True
    ) -> IntervalResult | None:
        """Simulate shares of the intervals after some nodes, shape (k,), as for `run`."""
        lengths = shares * (at.duration / self.intervals)
        x, u, p = at.x[nodes], at.u[nodes], at.parameters
        return self.dynamics.run(x, u, lengths, derivatives, p, nodes)

    def clip(self, iterate: Iterate) -> Iterate:
        """Return the nearest iterate within the bounds of controls, duration, parameters and start.

        Parameters that the iterate lacks are nominal.
        """
        parameters = self.parameters
        p = iterate.parameters if len(iterate.parameters) else parameters.nominal
        x = iterate.x.copy()
        x[0] = np.clip(x[0], self.x_low[0], self.x_high[0])
        return Iterate(
            x,
            np.clip(iterate.u, self.u_low, self.u_high),
            float(np.clip(iterate.duration, *self.duration)),
            np.clip(p, parameters.low, parameters.high),
        )


def excess(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the distance of values from a range, 0 inside."""
    return np.maximum(np.maximum(low - values, values - high), 0.0)
