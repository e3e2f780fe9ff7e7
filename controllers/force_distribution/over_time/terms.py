"""Fibres, tendons and torques of an iterate, with their derivatives."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from controllers.arrays import FloatArray

from .problem import MuscleProblem

_DIFFERENCE = 1e-6  # step of second derivatives
_SPEED = 10.0  # scale of fibre velocities, in optimal fibre lengths per second
_TINY = 1e-30


class Terms(NamedTuple):
    """Values at an iterate, and their derivatives. The first axis is that of the m muscles.

    Attributes:
        points: Points of the fibres, shape (N, m, 5).
        excitations: Between frames, shape (m, N - 1).
        balance: Fibre minus tendon force over F0, shape (m, N); 0 for rigid tendons.
        tensions: Shape (m, N), in [N].
        torque: L'f + tau, shape (N, n).
        local: Derivatives of (a, fibre length, fibre velocity), scaled, by (x before, a, x after),
            shape (m, N, 3, 3).
        slopes: Derivatives of fibre forces over F0 by the same scaled variables, shape (m, N, 3).
        by_balance: Derivatives of the balance by (x before, a, x after), shape (m, N, 3).
        by_tension: Derivatives of the tensions by the same, shape (m, N, 3).
        by_excitation: Derivatives of the excitations by (a, next a), shape (m, N - 1, 2).
        by_x: Derivatives of the fibre lengths between frames by x, shape (m, N + 1).
    """

    points: FloatArray
    excitations: FloatArray
    balance: FloatArray
    tensions: FloatArray
    torque: FloatArray
    local: FloatArray
    slopes: FloatArray
    by_balance: FloatArray
    by_tension: FloatArray
    by_excitation: FloatArray
    by_x: FloatArray


class MuscleTerms:
    """Evaluation of iterates: activations a at N frames, tendon forces x over F0 between frames."""

    def __init__(self, problem: MuscleProblem) -> None:
        self._problem = problem
        self._N, self._m, _ = problem.L.shape
        ones = np.ones(self._m)
        self._scale = np.stack([ones, problem.optimal, _SPEED * problem.optimal], axis=1)[:, None]
        self._F = problem.force[:, None]
        # (a, activation rate) between frames by (a, next a) at the frames
        self._edge = np.array([[0.5, 0.5], [-1.0 / problem.step, 1.0 / problem.step]])
        ends = 1.5 * problem.lengths[[0, -1]] - 0.5 * problem.lengths[[1, -2]]
        middle = (problem.lengths[1:] + problem.lengths[:-1]) / 2.0
        self._between = np.concatenate([ends[:1], middle, ends[1:]])

    def start(self, a: FloatArray, floor: float) -> FloatArray:
        """Return tendon forces between frames with rigid tendons, at least `floor`."""
        problem = self._problem
        points = np.zeros((self._N, self._m, 5))
        points[:, :, 0], points[:, :, 3] = a.T, problem.lengths
        points[:, :, 1] = np.maximum(problem.rigid_lengths, problem.shortest)
        points[:, :, 2] = problem.rigid_rates
        f = np.maximum(problem.model.fibres(points)[:, :, 0] / problem.force, floor).T
        return np.concatenate([f[:, :1], (f[:, 1:] + f[:, :-1]) / 2.0, f[:, -1:]], axis=1)

    def max_tensions(self) -> FloatArray:
        """Return the tendon forces between frames with the shortest fibres, shape (m, N + 1)."""
        points = np.zeros((self._N + 1, self._m, 5))
        points[:, :, 0], points[:, :, 3] = 0.5, self._between
        points[:, :, 1] = self._problem.shortest
        return np.asarray(self._problem.model.fibres(points)[:, :, 4] / self._problem.force).T

    def evaluate(self, a: FloatArray, x: FloatArray) -> Terms:
        """Return the terms of an iterate, shapes (m, N) and (m, N + 1)."""
        problem, h, elastic = self._problem, self._problem.step, self._problem.elastic
        tendons = problem.model.tendons(np.stack([x.T, self._between], axis=2))
        points, fibre = np.zeros((self._N, self._m, 5)), tendons[:, :, 0]
        points[:, :, 0], points[:, :, 3] = a.T, problem.lengths
        mean, rate = (fibre[1:] + fibre[:-1]) / 2.0, (fibre[1:] - fibre[:-1]) / h
        points[:, :, 1] = np.where(elastic, mean, problem.rigid_lengths)
        points[:, :, 2] = np.where(elastic, rate, problem.rigid_rates)
        values = np.swapaxes(problem.model.fibres(points), 0, 1)
        inner = points[:-1].copy()
        inner[:, :, 0], inner[:, :, 4] = (a[:, 1:] + a[:, :-1]).T / 2, (a[:, 1:] - a[:, :-1]).T / h
        inner = np.swapaxes(problem.model.fibres(inner), 0, 1)
        force, flags = (x[:, 1:] + x[:, :-1]) / 2.0, elastic[:, None]
        tensions = np.where(flags, self._F * force, values[:, :, 0])
        by_x = np.where(elastic, tendons[:, :, 1], 0.0).T
        local, slopes = self._local(by_x), self._slopes(values)
        by_balance = np.einsum("mki,mkij->mkj", slopes, local)
        by_balance[:, :, ::2] -= 0.5
        by_tension = np.zeros_like(by_balance)
        by_tension[:, :, ::2] = np.where(flags, 0.5 * self._F, 0.0)[:, :, None]
        by_tension[:, :, 1] = np.where(flags, 0.0, values[:, :, 1])
        return Terms(
            points,
            inner[:, :, 10],
            np.where(flags, values[:, :, 0] / self._F - force, 0.0),
            tensions,
            np.einsum("kmn,mk->kn", problem.L, tensions) + problem.tau,
            local,
            slopes,
            np.where(flags[:, :, None], by_balance, 0.0),
            by_tension,
            inner[:, :, 11:13] @ self._edge,
            by_x,
        )

    def _local(self, by_x: FloatArray) -> FloatArray:
        relative = by_x / self._problem.optimal[:, None]
        before, after, speed = relative[:, :-1], relative[:, 1:], _SPEED * self._problem.step
        local = np.zeros((self._m, self._N, 3, 3))
        local[:, :, 0, 1] = 1.0
        local[:, :, 1, 0], local[:, :, 1, 2] = before / 2.0, after / 2.0
        local[:, :, 2, 0], local[:, :, 2, 2] = -before / speed, after / speed
        return local

    def _slopes(self, values: FloatArray) -> FloatArray:
        slopes: FloatArray = values[:, :, 1:4] / self._F[:, :, None] * self._scale
        return slopes

    def hessian(self, terms: Terms, mu: FloatArray, x: FloatArray) -> FloatArray:
        """Return second derivatives of mu times the balance, shape (m, N, 3, 3).

        Args:
            mu: Multipliers of the balance, shape (m, N).
            x: Tendon forces over F0, shape (m, N + 1).
        """
        problem, H = self._problem, np.zeros((self._m, self._N, 3, 3))
        for j in (1, 2):
            points = terms.points.copy()
            points[:, :, j] += _DIFFERENCE * self._scale[:, 0, j]
            moved = self._slopes(np.swapaxes(problem.model.fibres(points), 0, 1))
            H[:, :, :, j] = mu[:, :, None] * (moved - terms.slopes) / _DIFFERENCE
        H[:, :, 1:, 0] = H[:, :, 0, 1:]
        H = 0.5 * (H + np.swapaxes(H, 2, 3))
        H = np.swapaxes(terms.local, 2, 3) @ H @ terms.local
        tendons = problem.model.tendons(np.stack([x.T + _DIFFERENCE, self._between], axis=2))
        bend = (tendons[:, :, 1].T - terms.by_x) / (_DIFFERENCE * problem.optimal[:, None])
        mean, speed = terms.slopes[:, :, 1] / 2.0, terms.slopes[:, :, 2] / (_SPEED * problem.step)
        H[:, :, 0, 0] += mu * (mean - speed) * bend[:, :-1]
        H[:, :, 2, 2] += mu * (mean + speed) * bend[:, 1:]
        H[~problem.elastic] = 0.0
        return H


def convex(H: FloatArray, added: FloatArray, A: FloatArray) -> FloatArray:
    """Return H with changes so that H + diag(added) is convex where A d = 0.

    Args:
        H: Symmetric matrices, shape (..., 3, 3).
        added: Diagonals, shape (..., 3).
        A: Vectors, shape (..., 3).
    """
    unit = A / np.maximum(np.linalg.norm(A, axis=-1, keepdims=True), _TINY)
    normal = unit.copy()  # of the reflection that maps A to the first axis
    normal[..., 0] += np.where(unit[..., 0] >= 0.0, 1.0, -1.0)
    factor = 1.0 / (1.0 + abs(unit[..., 0]))
    basis = np.broadcast_to(np.eye(3)[:, 1:], (*A.shape, 2)).copy()
    basis -= factor[..., None, None] * normal[..., :, None] * normal[..., None, 1:]
    damped = H + added[..., None] * np.eye(3)
    inner = basis.mT @ damped @ basis
    mean = (inner[..., 0, 0] + inner[..., 1, 1])[..., None, None] / 2.0
    rest = inner - mean * np.eye(2)  # eigenvalues -radius and radius
    radius = np.hypot(rest[..., 0, 0], rest[..., 0, 1])[..., None, None]
    direction = rest / np.maximum(radius, _TINY)
    low, high = np.maximum(radius - mean, 0.0), np.maximum(-radius - mean, 0.0)
    raised = ((low + high) * np.eye(2) + (high - low) * direction) / 2.0
    return np.asarray(H + basis @ raised @ basis.mT)
