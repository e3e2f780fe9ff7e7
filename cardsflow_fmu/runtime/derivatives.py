"""Directional derivatives of a model's outputs, by central differences.

In co-simulation, FMI describes a model by y[i+1] = Γ(x[i], u[i], p, h): the outputs after a step
are functions of state, inputs and tunable parameters at its beginning. The outputs are the
unknowns, the others are the knowns, and h is the preferred communication step. An output that is a
state is a known as well: the state at the beginning. At the start, before the first step, the
outputs are functions of the parameters and inputs that the initialization uses.

The derivative along the direction d is (Γ(v + s d) - Γ(v - s d)) / 2s, with s such that no known
changes by more than 1e-6 (1 + |v|). If Γ is smooth, the error is of order 1e-10 relative to
the second and third derivative.

Values beyond a limit of an input's range act like the limit, so Γ has a kink there: an ideal cable
cannot push. The difference is one-sided at a limit, towards the inside of the range, and zero
beyond it, as in native plants (see `tangent.h`). For this, v is moved away from the limit by at
most 1e-6 (1 + |v|), and the error is of this order relative to the second derivative. At other
kinks, such as joint limits or force limits of a controller, the result is the mean of both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.utils.arrays import FloatArray

Indices = NDArray[np.intp]

DIFFERENCE = 1e-6
"""Maximum change of a known in each direction, relative to 1 + |value|."""


class Differentiable(Protocol):
    """Model whose state and variables can be set, stepped and restored; see `FmuModel`."""

    ports: tuple[Port, ...]
    values: FloatArray
    states: Indices
    steady_outputs: Indices
    ranges: tuple[FloatArray, FloatArray]

    def initialize(self, t: float = 0.0) -> None:
        """Compute the outputs at the start."""

    def step(self, t: float, h: float) -> None:
        """Advance from t to t + h."""

    def get_state(self) -> bytes:
        """Return the state that is not in `values`."""

    def set_state(self, state: bytes) -> None:
        """Restore a state."""

    def set_states(self, states: FloatArray) -> None:
        """Set the outputs that are states."""


def directional_derivative(
    model: Differentiable, t: float, h: float, unknowns: Indices, knowns: Indices, seeds: FloatArray
) -> FloatArray:
    """Return the derivative of outputs along a direction; the model does not change.

    Args:
        model: The model, initialised.
        t: Current time, in [s].
        h: Length of a step, in [s]; 0 for the outputs at the start.
        unknowns: Indices of outputs.
        knowns: Indices of the variables that change.
        seeds: The direction, shape (len(knowns),).

    Returns:
        The derivative, shape (len(unknowns),).

    Raises:
        InputError: A variable in `knowns` is not a known.
    """
    _check(model, knowns, at_start=h == 0)
    direction = np.zeros(len(model.ports))
    np.add.at(direction, knowns, seeds)
    sizes = np.abs(direction) / (1.0 + np.abs(model.values))
    if not sizes.any():
        return np.zeros(len(unknowns))
    change = direction * (DIFFERENCE / sizes.max())
    evaluate = _start if h == 0 else _step
    offset = _shift_from_limits(model, np.abs(change))
    ahead, behind = (evaluate(model, t, h, offset + sign * change) for sign in (1.0, -1.0))
    slopes: FloatArray = (ahead - behind) / (2.0 * DIFFERENCE / sizes.max())
    slopes[model.steady_outputs] = 0.0
    return slopes[unknowns]


def _shift_from_limits(model: Differentiable, sizes: FloatArray) -> FloatArray:
    """Return the shift of the values that keeps changes of these sizes within the range."""
    v, (low, high) = model.values, model.ranges
    inside = np.clip(v, low + sizes, high - sizes)
    below, above = np.minimum(v, low - sizes), np.maximum(v, high + sizes)
    moved: FloatArray = np.where(v < low, below, np.where(v > high, above, inside)) - v
    return moved


def _check(model: Differentiable, knowns: Indices, *, at_start: bool) -> None:
    for k in knowns:
        port = model.ports[k]
        allowed = port.causality == "input"
        if at_start:
            allowed |= port.causality == "parameter"
        else:
            allowed |= k in model.states or port.variability == "tunable"
        if not allowed or port.boolean:
            when = "at the start" if at_start else "over a step"
            raise InputError(f"no derivative with respect to {port.name} {when}")


def _start(model: Differentiable, t: float, h: float, change: FloatArray) -> FloatArray:
    values = model.values.copy()

    def restore() -> None:
        model.values[:] = values
        model.initialize(t)

    def evaluate() -> None:
        model.values[:] += change
        model.initialize(t)

    return _outputs(model, evaluate, restore, values)


def _step(model: Differentiable, t: float, h: float, change: FloatArray) -> FloatArray:
    values, state = model.values.copy(), model.get_state()

    def restore() -> None:
        model.values[:] = values
        model.set_state(state)

    def evaluate() -> None:
        model.values[:] += change
        if change[model.states].any():
            model.set_states(model.values[model.states])
        model.step(t, h)

    return _outputs(model, evaluate, restore, values)


def _outputs(
    model: Differentiable,
    evaluate: Callable[[], None],
    restore: Callable[[], None],
    values: FloatArray,
) -> FloatArray:
    """Return the values after `evaluate`; restore the model."""
    try:
        evaluate()
        return model.values.copy()
    finally:
        restore()
        model.values[:] = values
