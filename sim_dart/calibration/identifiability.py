"""Identifiability of parameters, with descriptions of unidentifiable directions."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import eigh

from sim_dart.core.arrays import BoolArray, FloatArray

from .parameters import Parameter

_IDENTIFIED = 0.5
"""A parameter is identifiable if its sd is less than this fraction of its prior sd."""

_NO_EFFECT = 1e-2
"""Information in units of the prior below which a parameter has no effect.

It reduces the standard deviation by half a percent.
"""

_NAMED = 4
_PART = 0.25


class ParameterInformation(Protocol):
    """Information on parameters, from a `Calibration` or from the design of a motion."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters."""

    @property
    def information(self) -> FloatArray:
        """Information matrix of the measurements in units of the prior sd, shape (P, P)."""

    @property
    def prior(self) -> FloatArray:
        """Information matrix of the prior, shape (P, P)."""

    @property
    def sd(self) -> FloatArray:
        """Standard deviations with measurements and prior, shape (P,)."""


class UnidentifiableDirection(NamedTuple):
    """Combination of parameters that the measurements do not identify.

    Attributes:
        names: Names of the parameters with the largest weights.
        weights: Weights in units of the prior standard deviations.
        reason: Reason why the combination is unidentifiable.
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    reason: str

    def __str__(self) -> str:
        """Return a description of the direction."""
        parts = [f"{w:+.2f} {name}" for name, w in zip(self.names, self.weights, strict=True)]
        return f"{' '.join(parts)}: {self.reason}"


def identifiable(information: ParameterInformation) -> BoolArray:
    """Return flags of the parameters that the measurements identify, shape (P,)."""
    prior = np.array([parameter.sd for parameter in information.parameters])
    return np.asarray(information.sd < _IDENTIFIED * prior)


def without_effect(information: ParameterInformation) -> BoolArray:
    """Return flags of the parameters without effect on the measurements, shape (P,)."""
    return np.asarray(np.diag(information.information) < _NO_EFFECT)


def unidentifiable_directions(information: ParameterInformation) -> list[UnidentifiableDirection]:
    """Return the directions with less information from measurements than from the prior.

    The direction with the least information is first. Parameters without any effect are excluded;
    see `without_effect`.
    """
    visible = np.flatnonzero(~without_effect(information))
    block = np.ix_(visible, visible)
    values, vectors = eigh(information.information[block], information.prior[block])
    directions = np.zeros((len(information.parameters), len(visible)))
    directions[visible] = vectors / np.linalg.norm(vectors, axis=0)
    return [_direction(information, directions[:, k]) for k in np.flatnonzero(values < 1.0)]


def _direction(information: ParameterInformation, vector: FloatArray) -> UnidentifiableDirection:
    order = np.argsort(-np.abs(vector))
    most = abs(vector[order[0]])
    chosen = [k for k in order[:_NAMED] if abs(vector[k]) >= _PART * most]
    sign = np.sign(vector[chosen[0]])
    parameters = [information.parameters[k] for k in chosen]
    names = tuple(p.name for p in parameters)
    weights = tuple(float(sign * vector[k]) for k in chosen)
    kinds = {p.kind for p in parameters}
    return UnidentifiableDirection(names, weights, _reason(kinds, {p.group for p in parameters}))


def _reason(kinds: set[str], groups: set[str]) -> str:
    if kinds <= {"point", "offset", "stiffness"}:
        if kinds == {"point"} and len(groups) == 1:
            return "it does not change the muscle length at any pose of the recording"
        return "it changes lengths only by a constant at the poses of the recording"
    if kinds == {"inertia"}:
        return "no torque of the recorded motion depends on it, only on sums of such parameters"
    if kinds <= {"inertia", "gain"}:
        return "masses and tensions that are scaled by the same factor cause the same motion"
    if kinds <= {"damping", "friction", "cable_friction", "armature", "inertia"}:
        return "the recorded motion has too little speed or acceleration at this coordinate"
    return "its parameters have the same effect in the recorded motion"
