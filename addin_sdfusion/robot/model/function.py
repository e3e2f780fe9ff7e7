"""Functions of a coordinate. They drive joint motions, couple coordinates and move via points.

A scaled function is a function of the same kind. A sum of functions is expressed by several motions
about one axis, or by several terms of a coupling.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Union


@dataclass(frozen=True, slots=True)
class Polynomial:
    """Polynomial c_0 + c_1 x + c_2 x² + ...

    Attributes:
        coefficients: c_0, c_1, ...; at least one.
    """

    coefficients: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SimmSpline:
    """OpenSim's cubic spline through points, with linear extrapolation.

    The second derivative is continuous between the first and the last point. At each end it is
    determined by the cubic through the four nearest points, unlike in a natural spline.

    Attributes:
        x: Increasing x values of the points; at least two.
        y: Function values at x.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PiecewiseLinear:
    """Straight lines between points, with linear extrapolation.

    Attributes:
        x: Increasing x values of the points; at least two.
        y: Function values at x.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]


Function = Union[Polynomial, SimmSpline, PiecewiseLinear]  # noqa: UP007  used in isinstance below
ITSELF = Polynomial((0.0, 1.0))
"""Identity function f(x) = x."""

Cubic = tuple[float, float, float, float, float]
"""Coefficients x_k, a, b, c, d of a + D (b + D (c + D d)) with D = x - x_k."""


def constant(value: float) -> Polynomial:
    """Return the function f(x) = value."""
    return Polynomial((value,))


def linear(slope: float, offset: float = 0.0) -> Polynomial:
    """Return the function f(x) = slope x + offset."""
    return Polynomial((offset, slope))


def is_constant(function: Function) -> bool:
    """Return whether a function is constant."""
    if isinstance(function, Polynomial):
        return not any(function.coefficients[1:])
    return all(y == function.y[0] for y in function.y)


def scaled(function: Function, factor: float) -> Function:
    """Return the function times a factor."""
    if isinstance(function, Polynomial):
        return Polynomial(tuple(factor * c for c in function.coefficients))
    return replace(function, y=tuple(factor * y for y in function.y))


def taylor(coefficients: Sequence[float], at: float) -> tuple[float, ...]:
    """Return the coefficients in powers of x of a polynomial given in powers of x - at."""
    powers = [0.0] * len(coefficients)
    for coefficient in reversed(coefficients):
        moved = [0.0, *powers[:-1]]
        powers = [m + at * p for m, p in zip(moved, powers, strict=True)]
        powers[0] += coefficient
    return tuple(powers)


def derivatives(function: Function, x: float) -> tuple[float, float, float]:
    """Return f, f' and f'' at x.

    At a point of a piecewise linear function, the slope of the segment to its right is used.
    """
    if isinstance(function, Polynomial):
        f = slope = curvature = 0.0
        for c in reversed(function.coefficients):
            curvature = curvature * x + 2.0 * slope
            slope = slope * x + f
            f = f * x + c
        return f, slope, curvature
    at, a, b, c, d = _cubic_at(cubics(function), x)
    D = x - at
    return a + D * (b + D * (c + D * d)), b + D * (2.0 * c + D * 3.0 * d), 2.0 * c + D * 6.0 * d


def value(function: Function, x: float) -> float:
    """Return the function value f(x)."""
    return derivatives(function, x)[0]


@lru_cache(maxsize=4096)
def cubics(function: SimmSpline | PiecewiseLinear) -> tuple[Cubic, ...]:
    """Return the cubic pieces of a spline or piecewise linear function, from left to right.

    The first piece extrapolates to the left of the first point. Every other piece begins at its
    x_k; the last one extrapolates to the right.
    """
    if isinstance(function, PiecewiseLinear) or len(function.x) == 2:
        return _lines(function.x, function.y)
    return _spline(function.x, function.y)


def _cubic_at(pieces: Sequence[Cubic], x: float) -> Cubic:
    k = bisect_right(pieces, x, lo=1, key=lambda piece: piece[0]) - 1
    return pieces[k]


def _lines(x: Sequence[float], y: Sequence[float]) -> tuple[Cubic, ...]:
    points = list(pairwise(zip(x, y, strict=True)))
    slopes = [(yb - ya) / (xb - xa) for (xa, ya), (xb, yb) in points]
    starts = [
        (xa, ya, slope, 0.0, 0.0) for ((xa, ya), _), slope in zip(points, slopes, strict=True)
    ]
    return (starts[0], *starts, (x[-1], y[-1], slopes[-1], 0.0, 0.0))


def _spline(x: Sequence[float], y: Sequence[float]) -> tuple[Cubic, ...]:
    """Return the pieces of OpenSim's spline.

    As in OpenSim's source, solve for sigma, a sixth of the second derivatives at the points:
    h_(i-1) sigma_(i-1) + 2 (h_(i-1) + h_i) sigma_i + h_i sigma_(i+1) = s_i - s_(i-1).
    h are the distances and s the slopes between the points. One more equation at each end
    determines the cubic there.
    """
    n = len(x)
    h = [b - a for a, b in pairwise(x)]
    s = [(yb - ya) / step for (ya, yb), step in zip(pairwise(y), h, strict=True)]
    ends = [0.0, 0.0]
    if n > 3:
        first = (s[2] - s[1]) / (x[3] - x[1]) - (s[1] - s[0]) / (x[2] - x[0])
        last = (s[-1] - s[-2]) / (x[-1] - x[-3]) - (s[-2] - s[-3]) / (x[-2] - x[-4])
        ends = [first * h[0] ** 2 / (x[3] - x[0]), -last * h[-1] ** 2 / (x[-1] - x[-4])]
    right = [ends[0], *(b - a for a, b in pairwise(s)), ends[1]]
    diagonal = [-h[0], *(2.0 * (a + b) for a, b in pairwise(h)), -h[-1]]
    for i in range(1, n):
        share = h[i - 1] / diagonal[i - 1]
        diagonal[i] -= share * h[i - 1]
        right[i] -= share * right[i - 1]
    sigma = [0.0] * n
    sigma[-1] = right[-1] / diagonal[-1]
    for i in reversed(range(n - 1)):
        sigma[i] = (right[i] - h[i] * sigma[i + 1]) / diagonal[i]
    b = [s[k] - h[k] * (sigma[k + 1] + 2.0 * sigma[k]) for k in range(n - 1)]
    end = s[-1] + h[-1] * (sigma[-2] + 2.0 * sigma[-1])
    inner = [
        (x[k], y[k], b[k], 3.0 * sigma[k], (sigma[k + 1] - sigma[k]) / h[k]) for k in range(n - 1)
    ]
    return ((x[0], y[0], b[0], 0.0, 0.0), *inner, (x[-1], y[-1], end, 0.0, 0.0))
