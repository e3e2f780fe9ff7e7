"""Gains and sampled stability margins of computed-torque laws.

Computed torque turns every coordinate into a double integrator, e'' = -(Kd e' + Kp e). With a
sampling period T, a zero-order hold and a delay of d ticks, the closed-loop poles are the roots of

    z^d (z - 1)² + (Kp T²/2) (z + 1) + Kd T (z - 1) = 0.                                        (1)

This assumes an exact model and forces within their limits. Muscle forces that are held while the
robot moves act like springs, often with negative stiffness, and reduce the margins.
`linearise_loop` includes this effect. A loop that predicts over its delay is treated as a loop
without delay.

Only `lqr` imports python-control, since the import takes about 1 s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from addin_sdfusion.robot import InputError
from controllers.arrays import FloatArray
from controllers.validation import float_array, is_finite, require_delay, require_positive


class Gains(NamedTuple):
    """Gains of one coordinate: u = Kp e + Kd e' - k_held u_held.

    Attributes:
        kp: Position gain, in [1/s²].
        kd: Velocity gain, in [1/s].
        k_held: Gain on the previous command, which acts until the new command takes effect;
            dimensionless, 0 without delay.
    """

    kp: float
    kd: float
    k_held: float = 0.0


# Above this Kp/Kd² the root of the cubic equals its limit 2/3 Kd/Kp in double precision.
_MAX_STIFFNESS_RATIO = 1e12


@dataclass(frozen=True)
class Margins:
    """Stability margins of the sampled loop of a coordinate.

    The margins refer to the loop of eq. (1). A lower gain margin does not exist, since the loop
    remains stable for all smaller positive gains.

    Attributes:
        stable: Whether all poles are inside the unit circle.
        spectral_radius: Largest magnitude of a pole, dimensionless.
        gain_margin: Largest common factor on both gains, dimensionless; 0 when unstable.
        phase_margin: Phase margin, in [rad]; 0 when unstable.
        delay_margin: Additional delay that keeps the loop stable, in [s]; 0 when unstable.
            Approximate for long periods, since this delay is not an integer number of ticks.
        modulus_margin: Distance of the Nyquist curve from -1, dimensionless; 0 when unstable.
    """

    stable: bool
    spectral_radius: float
    gain_margin: float
    phase_margin: float
    delay_margin: float
    modulus_margin: float


def from_bandwidth(omega: float, zeta: float = 1.0) -> Gains:
    """Return gains that place both poles of a continuous loop: Kp = omega², Kd = 2 zeta omega.

    Args:
        omega: Bandwidth, in [rad/s].
        zeta: Damping ratio; 1 is critically damped.

    Raises:
        InputError: A value is not positive and finite.
    """
    require_positive(omega=omega, zeta=zeta)
    return Gains(omega**2, 2.0 * zeta * omega)


def lqr(q_weight: ArrayLike, r_weight: float, period: float = 0.0, delay: int = 0) -> Gains:
    """Return the gains that minimise the sum of T (x' Q x + r u²), x = (e, e').

    python-control solves the Riccati equation. With a delay, the gains belong to the
    delay-augmented loop: K₀ [A B], where K₀ are the gains without delay. This is equivalent to K₀
    applied to the state that is predicted for the time at which the command takes effect.

    Args:
        q_weight: Diagonal of Q, shape (2,), in [1/rad²] and [s²/rad²], or only its first number.
        r_weight: r, in [s⁴/rad²].
        period: T, in [s]; 0 for a continuous loop.
        delay: Ticks until a command takes effect: 0 or 1.

    Raises:
        InputError: A weight, the period or the delay is wrong.
    """
    import control

    Q = np.diag(_state_weights(q_weight))
    require_positive(r_weight=r_weight)
    require_delay(delay)
    if period == 0.0:
        if delay:
            raise InputError("a delay in ticks requires a period")
        A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
        return _solve_riccati(control.lqr, A, B, Q, r_weight)
    require_positive(period=period)
    A, B = _double_integrator(period)
    if delay:
        A = np.block([[A, B], [np.zeros((1, 3))]])
        B = np.array([[0.0], [0.0], [1.0]])
        Q = np.diag([*np.diag(Q), 0.0])
    return _solve_riccati(control.dlqr, A, B, Q, r_weight)


def _solve_riccati(
    riccati: Callable[..., Any], A: FloatArray, B: FloatArray, Q: FloatArray, r: float
) -> Gains:
    """Return the gains of a Riccati solver of python-control."""
    try:
        with np.errstate(all="ignore"):
            K, _, _ = riccati(A, B, Q, r)
    except (np.linalg.LinAlgError, ValueError):
        weights = np.diag(Q)[:2].tolist()
        raise InputError(f"no gains found for weights {weights} and r_weight {r!r}") from None
    return Gains(*map(float, K[0]))


def poles(kp: float, kd: float, period: float, delay: int = 0) -> NDArray[np.complex128]:
    """Return the poles of the sampled loop of one coordinate, eq. (1), shape (2 + delay,).

    Args:
        kp: Position gain, in [1/s²].
        kd: Velocity gain, in [1/s].
        period: T, in [s].
        delay: Ticks until a command takes effect: 0 or 1.

    Raises:
        InputError: A gain, the period or the delay is wrong.
    """
    _check_loop(kp, kd, period, delay)
    a, b = 0.5 * kp * period**2, kd * period
    polynomial = np.concatenate([[1.0, -2.0, 1.0], np.zeros(delay)])
    polynomial[-2:] += [a + b, a - b]
    return np.roots(polynomial).astype(np.complex128)


def margins(kp: float, kd: float, period: float, delay: int = 0) -> Margins:
    """Return the stability margins of the sampled loop of one coordinate.

    With a = Kp T²/2 and b = Kd T the open loop is

        L(z) = z^-d (a (z + 1) + b (z - 1)) / (z - 1)²,   z = exp(i w),

    and its magnitude crosses 1 once, at the positive root s = sin²(w/2) of
    4 s² - (b² - a²) s - a² = 0. The function uses closed forms, since the numeric margins of
    python-control fail at short periods, when all roots are near 1.

    Args:
        kp: Position gain, in [1/s²], positive.
        kd: Velocity gain, in [1/s], positive.
        period: T, in [s].
        delay: Ticks until a command takes effect: 0 or 1.

    Raises:
        InputError: A gain, the period or the delay is wrong.
    """
    require_positive(kp=kp, kd=kd)
    radius = float(np.abs(poles(kp, kd, period, delay)).max())
    if period >= largest_stable_period(kp, kd, delay):
        return Margins(False, radius, 0.0, 0.0, 0.0, 0.0)
    a, b = 0.5 * kp * period**2, kd * period
    half = (b - a) * (b + a)
    root = math.hypot(half, 4.0 * a)
    s = (half + root) / 8.0 if half > 0 else 2.0 * a**2 / (root - half)
    w = 2.0 * math.asin(math.sqrt(s))
    phase = math.atan2(b * math.sin(w / 2), a * math.cos(w / 2)) - (0.5 + delay) * w
    return Margins(
        True,
        radius,
        _gain_margin(kp, kd, period, delay),
        phase,
        phase / w * period,
        _modulus_margin(a, b, delay, w),
    )


def largest_stable_period(kp: float, kd: float, delay: int = 0) -> float:
    """Return the period below which the sampled loop of one coordinate is stable, in [s].

    The Jury criterion on eq. (1) yields, without delay, the smaller of 2/Kd and 2 Kd/Kp. With a
    delay of one tick it yields the smallest positive root of Kd - 3/2 Kp T - T (Kd - Kp T/2)².
    Without a position gain, only the velocity loop is checked. A coordinate without gains is not
    controlled, so that its loop is never unstable.

    Args:
        kp: Position gain, in [1/s²].
        kd: Velocity gain, in [1/s].
        delay: Ticks until a command takes effect: 0 or 1.

    Raises:
        InputError: A gain or the delay is wrong.
    """
    _check_loop(kp, kd, 1.0, delay)
    if kd == 0.0:
        return 0.0 if kp else math.inf
    if delay == 0:
        return min(2.0 / kd, 2.0 * kd / kp if kp else math.inf)
    # With x = Kd T and k = Kp/Kd² the polynomial is 1 - (1 + 3k/2) x + k x² - k²/4 x³, whose
    # coefficients are well scaled for all gains.
    k = kp / kd / kd
    if k > _MAX_STIFFNESS_RATIO:
        return 2.0 * kd / (3.0 * kp)
    roots = np.roots([-0.25 * k**2, k, -(1.0 + 1.5 * k), 1.0])
    real = roots.real[np.abs(roots.imag) < 1e-9 * (1.0 + np.abs(roots))]
    return float(real[real > 0].min()) / kd


def sampling_warning(
    kp: ArrayLike,
    kd: ArrayLike,
    period: float,
    delay: int = 0,
    names: Sequence[str] | None = None,
) -> str | None:
    """Return a one-line warning if the sampled loop is unstable, or None.

    Args:
        kp: Position gains, a number or shape (n,), in [1/s²].
        kd: Velocity gains, a number or shape (n,), in [1/s].
        period: T, in [s].
        delay: Ticks until a command takes effect, 0 or 1; 0 for a loop that predicts over its
            delay.
        names: n names of the coordinates, for the message.

    Raises:
        InputError: A gain, the period or the delay is wrong.
    """
    require_positive(period=period)
    gains = [np.atleast_1d(float_array(name, gain)) for name, gain in (("kp", kp), ("kd", kd))]
    try:
        rows = np.broadcast_arrays(*gains)
    except ValueError:
        raise InputError(f"kp {kp!r} and kd {kd!r} must have equal lengths") from None
    pairs = [(float(p), float(d)) for p, d in zip(*rows, strict=True)]
    limits = {pair: largest_stable_period(*pair, delay) for pair in dict.fromkeys(pairs)}
    worst = min(range(len(pairs)), key=lambda k: limits[pairs[k]])
    p, d = pairs[worst]
    limit = limits[p, d]
    if period < limit:
        return None
    coordinate = "" if names is None or len(limits) == 1 else f" of {names[worst]!r}"
    latency = " and one tick of delay" if delay else ""
    advice = (
        f"use a period below {limit * 1e3:.3g} ms, or smaller gains"
        if limit
        else "use a positive kd"
    )
    return (
        f"the loop{coordinate} with kp {p:g}, kd {d:g}, a period of {period * 1e3:g} ms{latency}"
        f" is unstable: {advice}"
    )


def _gain_margin(kp: float, kd: float, T: float, delay: int) -> float:
    """Return the factor on both gains that moves a pole to the unit circle (Jury criterion)."""
    if delay == 0:
        return 2.0 / (kd * T)
    return (kd - 1.5 * kp * T) / (T * (kd - 0.5 * kp * T) ** 2)


def _modulus_margin(a: float, b: float, delay: int, crossing: float) -> float:
    """Return the minimum of |1 + L(exp(i w))|, on a grid that is refined near the minimum."""
    w = np.sort(np.append(np.geomspace(0.05 * crossing, math.pi, 400), crossing))
    for _ in range(4):
        half = 0.5 * w
        turned = (a * np.cos(half) + 1j * b * np.sin(half)) * np.exp(-1j * (1 + 2 * delay) * half)
        distance = np.abs(1.0 - turned / (2.0 * np.sin(half) ** 2))
        k = int(np.argmin(distance))
        w = np.linspace(w[max(k - 1, 0)], w[min(k + 1, len(w) - 1)], 101)
    return float(distance[k])


def _double_integrator(T: float) -> tuple[FloatArray, FloatArray]:
    """Return A and B of e'' = u, sampled with a zero-order hold."""
    return np.array([[1.0, T], [0.0, 1.0]]), np.array([[0.5 * T**2], [T]])


def _state_weights(q_weight: ArrayLike) -> FloatArray:
    weights = np.atleast_1d(float_array("q_weight", q_weight))
    if weights.shape == (1,):
        weights = np.array([weights[0], 0.0])
    if weights.shape != (2,) or not np.isfinite(weights).all() or (weights < 0).any():
        raise InputError(
            f"q_weight must be one or two finite non-negative numbers, not {q_weight!r}"
        )
    if weights[0] == 0.0:
        raise InputError("the first number of q_weight, the position weight, must be positive")
    return weights


def _check_loop(kp: float, kd: float, period: float, delay: int) -> None:
    for name, value in (("kp", kp), ("kd", kd)):
        if not (is_finite(value) and value >= 0):
            raise InputError(f"{name} must be finite and not negative, not {value!r}")
    require_positive(period=period)
    require_delay(delay)
