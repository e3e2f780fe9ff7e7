"""Gains and sampled stability margins of computed-torque laws.

Computed torque makes every coordinate a double integrator, e'' = -(Kd e' + Kp e). Sampled with
period T, held in between, and late by d ticks, its closed loop has the poles of

    z^d (z - 1)² + (Kp T²/2) (z + 1) + Kd T (z - 1) = 0.                                        (1)

That is the loop of a perfect model whose forces stay within their bounds. Muscle forces held while
the robot moves act as springs, often as negative ones, which costs margin: `linearise_loop` has
that in it. A loop that predicts over its delay counts as one without.

Only `lqr` imports python-control: it takes a second.
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
        k_held: Gain on the command that still acts while the new one is on its way, without unit;
            0 without delay.
    """

    kp: float
    kd: float
    k_held: float = 0.0


_STIFF = 1e12  # Kp/Kd² above which the cubic's root is its limit, 2/3 Kd/Kp, to all digits


@dataclass(frozen=True)
class Margins:
    """Stability margins of the sampled loop of a coordinate.

    The loop is that of eq. (1). There is no lower gain margin: smaller gains keep it stable, down
    to zero if it is not held at all.

    Attributes:
        stable: Whether all poles are inside the unit circle.
        spectral_radius: Largest magnitude of a pole, without unit.
        gain_margin: How many times both gains may grow, without unit; 0 when unstable.
        phase_margin: In [rad]; 0 when unstable.
        delay_margin: Further delay that it bears, in [s]; 0 when unstable. For periods that are not
            short it is approximate, as the delay then is not a whole number of ticks.
        modulus_margin: Distance of the Nyquist curve from -1, without unit; 0 when unstable.
    """

    stable: bool
    spectral_radius: float
    gain_margin: float
    phase_margin: float
    delay_margin: float
    modulus_margin: float


def from_bandwidth(omega: float, zeta: float = 1.0) -> Gains:
    """Gains that place both poles of a continuous loop: Kp = omega², Kd = 2 zeta omega.

    Args:
        omega: Bandwidth, in [rad/s].
        zeta: Damping ratio; 1 is critically damped.

    Raises:
        InputError: A value is not positive and finite.
    """
    require_positive(omega=omega, zeta=zeta)
    return Gains(omega**2, 2.0 * zeta * omega)


def lqr(q_weight: ArrayLike, r_weight: float, period: float = 0.0, delay: int = 0) -> Gains:
    """Gains that make the sum of T (x' Q x + r u²) least, x = (e, e'), by python-control.

    With a delay they are those of the delay-augmented loop, K₀ [A B] with K₀ the gains without
    delay: the same as K₀ on the state predicted for when the command takes effect.

    Args:
        q_weight: Diagonal of Q, shape (2,), in [1/rad²] and [s²/rad²], or its first number alone.
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
        return _solved(control.lqr, A, B, Q, r_weight)
    require_positive(period=period)
    A, B = _double_integrator(period)
    if delay:
        A = np.block([[A, B], [np.zeros((1, 3))]])
        B = np.array([[0.0], [0.0], [1.0]])
        Q = np.diag([*np.diag(Q), 0.0])
    return _solved(control.dlqr, A, B, Q, r_weight)


def _solved(
    riccati: Callable[..., Any], A: FloatArray, B: FloatArray, Q: FloatArray, r: float
) -> Gains:
    """Return the gains by a function of python-control."""
    try:
        with np.errstate(all="ignore"):
            K, _, _ = riccati(A, B, Q, r)
    except (np.linalg.LinAlgError, ValueError):
        weights = np.diag(Q)[:2].tolist()
        raise InputError(f"no gains found for weights {weights} and r_weight {r!r}") from None
    return Gains(*map(float, K[0]))


def poles(kp: float, kd: float, period: float, delay: int = 0) -> NDArray[np.complex128]:
    """Poles of the sampled loop of one coordinate, eq. (1), shape (2 + delay,).

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
    """Stability margins of the sampled loop of one coordinate.

    With a = Kp T²/2 and b = Kd T the open loop is

        L(z) = z^-d (a (z + 1) + b (z - 1)) / (z - 1)²,   z = exp(i w),

    and crosses magnitude 1 once, where sin²(w/2) is the positive root s of
    4 s² - (b² - a²) s - a² = 0. These are closed forms, as the numeric margins of python-control
    fail where all roots are near 1, which is at short periods.

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

    By the Jury criterion on eq. (1): the smaller of 2/Kd and 2 Kd/Kp without delay, the smallest
    positive root of Kd - 3/2 Kp T - T (Kd - Kp T/2)² with a delay of one tick. A coordinate without
    position gain is judged by its velocity; one without gains is not held, and never unstable.

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
    # In x = Kd T and k = Kp/Kd²: 1 - (1 + 3k/2) x + k x² - k²/4 x³, numbers near 1 for any gains.
    k = kp / kd / kd
    if k > _STIFF:
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
        delay: Ticks until a command takes effect, 0 or 1; 0 for a loop that predicts over it.
        names: n names of the coordinates, for the text.

    Raises:
        InputError: A gain, the period or the delay is wrong.
    """
    require_positive(period=period)
    gains = [np.atleast_1d(float_array(name, gain)) for name, gain in (("kp", kp), ("kd", kd))]
    try:
        rows = np.broadcast_arrays(*gains)
    except ValueError:
        raise InputError(f"kp {kp!r} and kd {kd!r} must be equally long") from None
    pairs = [(float(p), float(d)) for p, d in zip(*rows, strict=True)]
    limits = {pair: largest_stable_period(*pair, delay) for pair in dict.fromkeys(pairs)}
    worst = min(range(len(pairs)), key=lambda k: limits[pairs[k]])
    p, d = pairs[worst]
    limit = limits[p, d]
    if period < limit:
        return None
    who = "" if names is None or len(limits) == 1 else f" of {names[worst]!r}"
    late = " and one tick of delay" if delay else ""
    cure = (
        f"use a period below {limit * 1e3:.3g} ms, or smaller gains" if limit else "give it damping"
    )
    return (
        f"the loop{who} with kp {p:g}, kd {d:g}, a period of {period * 1e3:g} ms{late} is unstable:"
        f" {cure}"
    )


def _gain_margin(kp: float, kd: float, T: float, delay: int) -> float:
    """Return the factor on both gains that puts poles on the unit circle: Jury on eq. (1)."""
    if delay == 0:
        return 2.0 / (kd * T)
    return (kd - 1.5 * kp * T) / (T * (kd - 0.5 * kp * T) ** 2)


def _modulus_margin(a: float, b: float, delay: int, crossing: float) -> float:
    """The least |1 + L(exp(i w))|, on a grid about the crossing, ever finer if it is best."""
    w = np.sort(np.append(np.geomspace(0.05 * crossing, math.pi, 400), crossing))
    for _ in range(4):
        half = 0.5 * w
        turned = (a * np.cos(half) + 1j * b * np.sin(half)) * np.exp(-1j * (1 + 2 * delay) * half)
        distance = np.abs(1.0 - turned / (2.0 * np.sin(half) ** 2))
        k = int(np.argmin(distance))
        w = np.linspace(w[max(k - 1, 0)], w[min(k + 1, len(w) - 1)], 101)
    return float(distance[k])


def _double_integrator(T: float) -> tuple[FloatArray, FloatArray]:
    """A, B of e'' = u, sampled and held."""
    return np.array([[1.0, T], [0.0, 1.0]]), np.array([[0.5 * T**2], [T]])


def _state_weights(q_weight: ArrayLike) -> FloatArray:
    weights = np.atleast_1d(float_array("q_weight", q_weight))
    if weights.shape == (1,):
        weights = np.array([weights[0], 0.0])
    if weights.shape != (2,) or not np.isfinite(weights).all() or (weights < 0).any():
        raise InputError(f"q_weight must be one or two numbers from 0 on, not {q_weight!r}")
    if weights[0] == 0.0:
        raise InputError("q_weight must weight the position: its first number must be positive")
    return weights


def _check_loop(kp: float, kd: float, period: float, delay: int) -> None:
    for name, value in (("kp", kp), ("kd", kd)):
        if not (is_finite(value) and value >= 0):
            raise InputError(f"{name} must be finite and not negative, not {value!r}")
    require_positive(period=period)
    require_delay(delay)
