"""Problem of muscles over a whole given motion, and its solution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from controllers.arrays import BoolArray, FloatArray


class FibreModel(Protocol):
    """Fibres and tendons of m Hill-type muscles; `core.h` describes the numbers."""

    def fibres(self, points: FloatArray) -> FloatArray:
        """Return the values of `core_fibres` at points, shape (K, m, 5) to (K, m, 14)."""

    def tendons(self, points: FloatArray) -> FloatArray:
        """Return the values of `core_tendons` at points, shape (K, m, 2) to (K, m, 2)."""


@dataclass(frozen=True, eq=False)
class MuscleProblem:
    """Muscles along a motion with N equidistant frames.

    Attributes:
        step: Time between frames, in [s].
        L: Muscle Jacobians, shape (N, m, n); every coordinate has a muscle.
        tau: Torques that muscles and reserves must produce, shape (N, n), in [N·m] or [N].
        lengths: Path lengths, shape (N, m), in [m].
        model: Fibres and tendons.
        elastic: Whether the tendon of a muscle is elastic, shape (m,).
        rigid_lengths: Fibre lengths with rigid tendons, shape (N, m), in [m].
        rigid_rates: Fibre velocities with rigid tendons, shape (N, m), in [m/s].
        force: Maximum isometric forces F0, shape (m,), in [N].
        optimal: Optimal fibre lengths, shape (m,), in [m].
        shortest: Shortest fibre lengths, shape (m,), in [m].
        low: Minimum activations and excitations, shape (m,).
        reserve: Torques of reserves at a cost of 1, shape (n,), in [N·m] or [N].
        power: Exponent p of the excitations, above 1.
    """

    step: float
    L: FloatArray
    tau: FloatArray
    lengths: FloatArray
    model: FibreModel
    elastic: BoolArray
    rigid_lengths: FloatArray
    rigid_rates: FloatArray
    force: FloatArray
    optimal: FloatArray
    shortest: FloatArray
    low: FloatArray
    reserve: FloatArray
    power: float = 2.0


class MuscleTrajectory(NamedTuple):
    """Muscles over a motion.

    Attributes:
        activations: At frames, shape (N, m).
        excitations: At frames, shape (N, m).
        tensions: At frames, shape (N, m), in [N].
        fibre_lengths: At frames, shape (N, m), in [m].
        fibre_rates: At frames, shape (N, m), in [m/s].
        reserves: Torques at frames, shape (N, n), in [N·m] or [N].
        cost: The minimum.
        is_solved: Whether the optimality conditions hold.
    """

    activations: FloatArray
    excitations: FloatArray
    tensions: FloatArray
    fibre_lengths: FloatArray
    fibre_rates: FloatArray
    reserves: FloatArray
    cost: float
    iterations: int
    is_solved: bool
