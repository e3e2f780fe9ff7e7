"""Cost of a motion: integrals of weighted squares, and the duration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray


class CostTerms(NamedTuple):
    """Gradient and Gauss-Newton Hessian of a cost, for states x, controls u and duration T.

    The Hessian of the states and of the controls is diagonal; the controls of adjacent intervals
    and the duration are coupled to it.

    Attributes:
        gx, gu, gt: Gradients, shapes (N + 1, nx), (N, nu), ().
        xx, uu, tt: Diagonals of the Hessian, of the same shapes.
        uv: Coupling of the controls of an interval and of the next one, shape (N - 1, nu).
        xt, ut: Coupling with the duration, shapes (N + 1, nx), (N, nu).
    """

    gx: FloatArray
    gu: FloatArray
    gt: float
    xx: FloatArray
    uu: FloatArray
    tt: float
    uv: FloatArray
    xt: FloatArray
    ut: FloatArray


@dataclass(frozen=True)
class Costs:
    """Cost int(w_u (u - u0)^2 + w_x (x - x0)^2) dt + sum(w_v (u_k+1 - u_k)^2) / h + w_T T.

    Attributes:
        controls: w_u, shape (nu,).
        states: w_x, shape (nx,).
        rates: w_v, shape (nu,).
        time: w_T.
        control_target: u0, shape (nu,).
        state_target: x0, shape (nx,) or (N + 1, nx).
    """

    controls: FloatArray
    states: FloatArray
    rates: FloatArray
    time: float
    control_target: FloatArray
    state_target: FloatArray

    def value(self, x: FloatArray, u: FloatArray, T: float) -> float:
        """Return the cost of states x, shape (N + 1, nx), and controls u, shape (N, nu)."""
        h = T / len(u)
        states = _trapezoid(len(u)) @ (x - self.state_target) ** 2 @ self.states
        controls = ((u - self.control_target) ** 2 @ self.controls).sum()
        rates = (np.diff(u, axis=0) ** 2 @ self.rates).sum()
        return float(h * (states + controls) + rates / h + self.time * T)

    def terms(self, x: FloatArray, u: FloatArray, T: float) -> CostTerms:
        """Return gradient and Hessian at states x, controls u and duration T."""
        count = len(u)
        h = T / count
        share = _trapezoid(count)[:, None]
        e, v, step = x - self.state_target, u - self.control_target, np.diff(u, axis=0)
        gx, gu = 2.0 * h * share * self.states * e, 2.0 * h * self.controls * v
        xx = 2.0 * h * share * np.broadcast_to(self.states, x.shape)
        uu = 2.0 * h * np.broadcast_to(self.controls, u.shape).copy()
        rate = 2.0 * self.rates / h
        gu[1:] += rate * step
        gu[:-1] -= rate * step
        uu[1:] += rate
        uu[:-1] += rate
        integral = ((share * e**2) @ self.states).sum() + (v**2 @ self.controls).sum()
        rates = (step**2 @ self.rates).sum()
        gt = integral / count - rates * count / T**2 + self.time
        # residuals sqrt(h w) e and sqrt(w / h) step, whose derivatives by T are -1/2 to 1/2 / T
        xt, ut = gx / (2.0 * T), 2.0 * h * self.controls * v / (2.0 * T)
        ut[1:] -= rate * step / (2.0 * T)
        ut[:-1] += rate * step / (2.0 * T)
        tt = (integral / count + rates * count / T**2) / (2.0 * T)
        uv = np.broadcast_to(-rate, step.shape)
        return CostTerms(gx, gu, float(gt), xx, uu, float(tt), uv, xt, ut)


def _trapezoid(count: int) -> FloatArray:
    """Return the weights of the nodes in an integral, relative to the interval, shape (N + 1,)."""
    weights = np.ones(count + 1)
    weights[[0, -1]] = 0.5
    return weights
