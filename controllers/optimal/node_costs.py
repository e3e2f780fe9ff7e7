"""Costs of the states at nodes: weighted squares, and functions without known derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controllers.arrays import FloatArray, IntArray

from .convexity import positive_part

_STEP = 1e-4  # of finite differences of gradients


@dataclass(frozen=True)
class NodeCost:
    """Cost of the states at some nodes: the integral over time, or the sum.

    Attributes:
        nodes: Indices of the nodes, shape (k,).
        is_integral: Whether the cost is integrated over time by the trapezoidal rule.
        value: Function of states, shape (k, nx), that returns the cost at each node, shape (k,).
        gradient: Function that returns its gradients, shape (k, nx).
        hessian: Function that returns positive semidefinite Hessians, shape (k, nx, nx).
    """

    nodes: IntArray
    is_integral: bool
    value: Callable[[FloatArray], FloatArray]
    gradient: Callable[[FloatArray], FloatArray]
    hessian: Callable[[FloatArray], FloatArray]


def squares(
    nodes: IntArray,
    is_integral: bool,
    evaluate: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
    weights: FloatArray,
    target: FloatArray,
) -> NodeCost:
    """Return the cost sum(w (g(x) - g0)^2) with the Gauss-Newton Hessian.

    Args:
        nodes: Indices of the nodes, shape (k,).
        is_integral: Whether the cost is integrated over time.
        evaluate: Function of states, shape (k, nx), that returns g, shape (k, r), and its
            derivatives, shape (k, r, nx).
        weights: w, shape (r,).
        target: g0, shape (r,) or (k, r).
    """

    def value(x: FloatArray) -> FloatArray:
        costs: FloatArray = (evaluate(x)[0] - target) ** 2 @ weights
        return costs

    def gradient(x: FloatArray) -> FloatArray:
        g, J = evaluate(x)
        return np.asarray(2.0 * np.einsum("kr,kri->ki", weights * (g - target), J))

    def hessian(x: FloatArray) -> FloatArray:
        J = evaluate(x)[1]
        return np.asarray(2.0 * np.einsum("kri,r,krj->kij", J, weights, J))

    return NodeCost(nodes, is_integral, value, gradient, hessian)


def function_cost(
    nodes: IntArray,
    is_integral: bool,
    value: Callable[[FloatArray], FloatArray],
    gradient: Callable[[FloatArray], FloatArray],
    used: int,
) -> NodeCost:
    """Return the cost of a function; its Hessian is by differences, without negative curvature.

    Args:
        nodes: Indices of the nodes, shape (k,).
        is_integral: Whether the cost is integrated over time.
        value: See `NodeCost`.
        gradient: See `NodeCost`.
        used: Number of states, from the first one, that the function depends on.
    """

    def hessian(x: FloatArray) -> FloatArray:
        H, at = np.zeros((*x.shape, x.shape[1])), gradient(x)
        for k in range(used):
            moved = x.copy()
            moved[:, k] += _STEP
            H[:, k] = (gradient(moved) - at) / _STEP
        return positive_part(0.5 * (H + H.transpose(0, 2, 1)))

    return NodeCost(nodes, is_integral, value, gradient, hessian)
