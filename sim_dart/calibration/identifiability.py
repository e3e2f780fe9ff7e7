"""Numbers that readings identify, and the directions that they leave open, in words."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import eigh

from sim_dart.core.arrays import BoolArray, FloatArray

from .parameters import Parameter

_IDENTIFIED = 0.5
"""A number is identifiable where less than that of its prior's deviation is left."""

_NO_EFFECT = 1e-2
"""Information in units of the prior: half a percent off its deviation."""

_NAMED = 4
_PART = 0.25


class Knowledge(Protocol):
    """What readings tell of parameters: of a `Calibration`, or of a motion that is designed."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """What was free."""

    @property
    def information(self) -> FloatArray:
        """By the readings alone, in units of the prior's deviations, shape (P, P)."""

    @property
    def prior(self) -> FloatArray:
        """That of what is believed, shape (P, P)."""

    @property
    def sd(self) -> FloatArray:
        """Standard deviations with both, shape (P,)."""


class OpenDirection(NamedTuple):
    """A combination of parameters that the readings do not identify.

    Attributes:
        names: What it changes most.
        weights: By how much of their prior's deviations.
        reason: Why it cannot be seen.
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    reason: str

    def __str__(self) -> str:
        """In words."""
        parts = [f"{w:+.2f} {name}" for name, w in zip(self.names, self.weights, strict=True)]
        return f"{' '.join(parts)}: {self.reason}"


def identifiable(known: Knowledge) -> BoolArray:
    """Which parameters the readings identify, beyond the prior, shape (P,)."""
    prior = np.array([one.sd for one in known.parameters])
    return np.asarray(known.sd < _IDENTIFIED * prior)


def without_effect(known: Knowledge) -> BoolArray:
    """Which parameters change nothing that was recorded, shape (P,)."""
    return np.asarray(np.diag(known.information) < _NO_EFFECT)


def open_directions(known: Knowledge) -> list[OpenDirection]:
    """Directions of which the readings say less than the prior does, the least seen first.

    Parameters that have no effect by themselves are none of them; see `without_effect`.
    """
    seen = np.flatnonzero(~without_effect(known))
    part = np.ix_(seen, seen)
    values, vectors = eigh(known.information[part], known.prior[part])
    whole = np.zeros((len(known.parameters), len(seen)))
    whole[seen] = vectors / np.linalg.norm(vectors, axis=0)
    return [_direction(known, whole[:, k]) for k in np.flatnonzero(values < 1.0)]


def _direction(known: Knowledge, vector: FloatArray) -> OpenDirection:
    order = np.argsort(-np.abs(vector))
    most = abs(vector[order[0]])
    chosen = [k for k in order[:_NAMED] if abs(vector[k]) >= _PART * most]
    sign = np.sign(vector[chosen[0]])
    parameters = [known.parameters[k] for k in chosen]
    names = tuple(one.name for one in parameters)
    weights = tuple(float(sign * vector[k]) for k in chosen)
    kinds = {one.kind for one in parameters}
    return OpenDirection(names, weights, _reason(kinds, {one.group for one in parameters}))


def _reason(kinds: set[str], groups: set[str]) -> str:
    if kinds <= {"point", "offset", "stiffness"}:
        if kinds == {"point"} and len(groups) == 1:
            return "it leaves the muscle's lengths as they are at all poses of the recording"
        return "lengths change by a constant alone, or not at all, at the poses of the recording"
    if kinds == {"inertia"}:
        return "no torque of the recorded motion depends on it: only sums of such numbers act"
    if kinds <= {"inertia", "gain"}:
        return "masses and tensions by the same factor make the same motion"
    if kinds <= {"damping", "friction", "cable_friction", "armature", "inertia"}:
        return "the recorded motion has too little speed or acceleration there"
    return "its parts act alike in the recorded motion"
