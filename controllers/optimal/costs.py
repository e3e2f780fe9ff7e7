"""Cost of a motion: integrals of weighted squares, and the duration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray

from .node_costs import NodeCost


class CostTerms(NamedTuple):
    """Gradient and Gauss-Newton Hessian of a cost, for states x, controls u and duration T.

    The Hessian of the controls is diagonal, and so is that of the states without costs of nodes.
    Those of adjacent nodes or intervals and the duration are coupled to it.

    Attributes:
        gx, gu, gt: Gradients, shapes (N + 1, nx), (N, nu), ().
        xx, uu, tt: Diagonals of the Hessian, of the same shapes.
        uv: Coupling of the controls of an interval and of the next one, shape (N - 1, nu).
        xv: Coupling of the states of a node and of the next one, shape (N, nx).
        dense: Hessian of the states of each node without its diagonal, which is part of xx, shape
            (N + 1, nx, nx).
        xt, ut: Coupling with the duration, shapes (N + 1, nx), (N, nu).
    """

    gx: FloatArray
    gu: FloatArray
    gt: float
    xx: FloatArray
    uu: FloatArray
    tt: float
    uv: FloatArray
    xv: FloatArray
    dense: FloatArray
    xt: FloatArray
    ut: FloatArray


@dataclass(frozen=True)
class Costs:
    """Cost int(w_u (u - u0)^2 + w_x (x - x0)^2) dt + costs of rates, of T, and of nodes.

    The costs of rates are sum(w_v (u_k+1 - u_k)^2) / h + sum(w_a (x_k+1 - x_k)^2) / h, and that of
    the duration is w_T T.

    Attributes:
        controls: w_u, shape (nu,).
        states: w_x, shape (nx,).
        rates: w_v, shape (nu,).
        time: w_T.
        control_target: u0, shape (nu,).
        state_target: x0, shape (nx,) or (N + 1, nx).
        state_rates: w_a, shape (nx,), or () for none.
        nodes: Costs of states at nodes.
    """

    controls: FloatArray
    states: FloatArray
    rates: FloatArray
    time: float
    control_target: FloatArray
    state_target: FloatArray
    state_rates: FloatArray = field(default_factory=lambda: np.array(0.0))
    nodes: Sequence[NodeCost] = ()

    def value(self, x: FloatArray, u: FloatArray, T: float) -> float:
        """Return the cost of states x, shape (N + 1, nx), and controls u, shape (N, nu)."""
        h = T / len(u)
        states = _trapezoid(len(u)) @ (x - self.state_target) ** 2 @ self.states
        controls = ((u - self.control_target) ** 2 @ self.controls).sum()
        rates = (np.diff(u, axis=0) ** 2 @ self.rates).sum()
        rates += (np.diff(x, axis=0) ** 2 * self.state_rates).sum()
        of_nodes = sum(self._shares(c, T, len(u)) @ c.value(x[c.nodes]) for c in self.nodes)
        return float(h * (states + controls) + rates / h + self.time * T + of_nodes)

    def _shares(self, cost: NodeCost, T: float, count: int) -> FloatArray:
        """Return the factors of the cost at the nodes of a cost, shape (k,)."""
        if cost.is_integral:
            return np.asarray(_trapezoid(count)[cost.nodes] * (T / count))
        return np.ones(len(cost.nodes))

    def terms(self, x: FloatArray, u: FloatArray, T: float) -> CostTerms:
        """Return gradient and Hessian at states x, controls u and duration T."""
        count = len(u)
        h = T / count
        share = _trapezoid(count)[:, None]
        e, v = x - self.state_target, u - self.control_target
        gx, gu = 2.0 * h * share * self.states * e, 2.0 * h * self.controls * v
        # residuals sqrt(h w) e and sqrt(w / h) step, whose derivatives by T are -1/2 to 1/2 / T
        xt, ut = gx / (2.0 * T), gu / (2.0 * T)
        xx = 2.0 * h * share * np.broadcast_to(self.states, x.shape)
        uu = 2.0 * h * np.broadcast_to(self.controls, u.shape).copy()
        uv, of_controls = _add_rates(2.0 * self.rates / h, u, T, (gu, uu, ut))
        xv, of_states = _add_rates(2.0 * self.state_rates / h, x, T, (gx, xx, xt))
        integral = ((share * e**2) @ self.states).sum() + (v**2 @ self.controls).sum()
        rates = (of_controls + of_states) / T
        gt = integral / count - rates + self.time
        tt = (integral / count + rates) / (2.0 * T)
        dense = np.zeros((count + 1, x.shape[1], x.shape[1]))
        for cost in self.nodes:
            at, factors = x[cost.nodes], self._shares(cost, T, count)
            gx[cost.nodes] += factors[:, None] * cost.gradient(at)
            dense[cost.nodes] += factors[:, None, None] * cost.hessian(at)
            gt += factors @ cost.value(at) / T if cost.is_integral else 0.0
        k = np.arange(x.shape[1])
        xx = xx + dense[:, k, k]
        dense[:, k, k] = 0.0
        return CostTerms(gx, gu, float(gt), xx, uu, float(tt), uv, xv, dense, xt, ut)


def _add_rates(
    rate: FloatArray,
    values: FloatArray,
    T: float,
    terms: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[FloatArray, float]:
    """Add the cost of rates to terms; return the coupling of adjacent rows, and the cost.

    Args:
        rate: Twice the weights divided by the length of an interval, shape (r,) or ().
        values: States or controls, shape (k, r).
        T: Duration.
        terms: Gradient, Hessian, and coupling with the duration, shape (k, r).
    """
    step, (g, H, t) = np.diff(values, axis=0), terms
    g[1:] += rate * step
    g[:-1] -= rate * step
    H[1:] += rate
    H[:-1] += rate
    t[1:] -= rate * step / (2.0 * T)
    t[:-1] += rate * step / (2.0 * T)
    return np.broadcast_to(-rate, step.shape), float(0.5 * (rate * step**2).sum())


def _trapezoid(count: int) -> FloatArray:
    """Return the weights of the nodes in an integral, relative to the interval, shape (N + 1,)."""
    weights = np.ones(count + 1)
    weights[[0, -1]] = 0.5
    return weights
