"""The law in joint space in single precision, for feasible and infeasible torques."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from numpy.typing import NDArray
from support.native.precision import Handle, Precision, room

pytestmark = pytest.mark.slow

SOLVED, SOFT = 0, 1
COUNT = 1500
F_MIN, F_MAX = 5.0, 200.0
FloatArray = NDArray[np.float64]


class Torque:
    """Desired torque of a random robot; about half of the torques are infeasible."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.n = int(rng.integers(1, 6))
        self.m = self.n + int(rng.integers(1, 8))
        parts = rng.normal(size=(self.n, self.n)) * 10.0 ** rng.uniform(-0.5, 0.0, self.n)
        self.M = parts @ parts.T + 0.03 * np.eye(self.n)
        self.L = rng.normal(size=(self.m, self.n)) * 0.05
        self.h = rng.normal(size=self.n)
        self.acceleration = rng.normal(size=self.n) * 10.0 ** rng.uniform(0.0, 2.0)

    def solve(self, precision: Precision, norm: int = 2) -> tuple[int, FloatArray]:
        """Return status and forces."""
        memory = room(precision.call("computed_torque_size", self.n, self.m, 0))
        opened = precision.call("computed_torque_open", self.n, self.m, 0, memory)
        law = Handle(precision, "computed_torque", opened)
        values = {"M": self.M, "h": self.h, "L": self.L, "acceleration": self.acceleration}
        for name, array in values.items():
            law.array(name)[:] = array.ravel()
        for name, number in {"f_min": F_MIN, "f_max": F_MAX, "H_f": 1.0, "norm": norm}.items():
            law.array(name)[:] = number
        law.call("reset")
        status = law.call("solve")
        return status, law.array("forces").astype(float)

    def error(self, forces: FloatArray) -> float:
        """Return the error of the acceleration due to the forces, in [rad/s²]."""
        torque = self.M @ self.acceleration + self.h + self.L.T @ forces
        return float(np.linalg.norm(np.linalg.solve(self.M, torque)))


def test_both_precisions_agree(single: Precision, double: Precision) -> None:
    """Status and forces agree; for infeasible torques the acceleration errors agree.

    If the mass matrix is ill-conditioned, different forces may have the same error.
    """
    found: Counter[tuple[int, int]] = Counter()
    off, excess = [], []
    for seed in range(COUNT):
        torque = Torque(seed)
        (status, forces), (true_status, true) = map(torque.solve, (single, double))
        found[status, true_status] += 1
        if true_status == SOLVED:
            off.append(np.abs(forces - true).max() / F_MAX)
        else:
            excess.append(torque.error(forces) / torque.error(true) - 1.0)
    print(f"\n{found[0, 0]} feasible, forces deviate by {max(off):.0e} of the largest;", end=" ")
    print(f"{found[1, 1]} infeasible, errors larger by {np.quantile(excess, 0.99):.0e} for 99 %")
    assert set(found) == {(SOLVED, SOLVED), (SOFT, SOFT)}
    assert max(off) < 1e-5
    assert np.quantile(excess, 0.95) < 1e-3
    assert np.quantile(excess, 0.99) < 0.1


@pytest.mark.parametrize("norm", [4, 8])
def test_norms_agree_in_both_precisions(norm: int, single: Precision, double: Precision) -> None:
    """They agree to the tolerance of a feasible torque in single precision."""
    off, solved = [], 0
    for seed in range(COUNT // 10):
        torque = Torque(seed)
        (status, forces), (true_status, true) = (torque.solve(p, norm) for p in (single, double))
        assert status == true_status
        if status == SOLVED:
            solved += 1
            off.append(np.linalg.norm(forces, norm) / np.linalg.norm(true, norm) - 1.0)
    assert solved > COUNT // 30
    assert np.abs(off).max() < 1e-4
