"""Random quadratic programs over stages, for the solver in C and as dense programs."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import qpsolvers

from controllers.qp import law_in_c
from sim_dart.core import library as core


def library() -> Any:
    """Return the C core with the functions of stage_qp.h."""
    c, pointer, whole = core.library(), ctypes.c_void_p, ctypes.c_int
    c.stage_qp_size.argtypes, c.stage_qp_size.restype = [whole] * 3, ctypes.c_size_t
    c.stage_qp_open.argtypes, c.stage_qp_open.restype = [*[whole] * 3, pointer], pointer
    c.stage_qp_array.argtypes = [pointer, ctypes.c_char_p, ctypes.POINTER(ctypes.c_size_t)]
    c.stage_qp_array.restype = pointer
    c.stage_qp_begin.argtypes = c.stage_qp_iterate.argtypes = [pointer]
    return c


class StageProgram(law_in_c.NamedArrays):
    """Handle of stage_qp.h; `program[name]` is one of its arrays."""

    def __init__(self, stages: int, states: int, controls: int) -> None:
        self.N, self.x, self.u = stages, states, controls
        self.w, self._c = states + controls, library()
        self.total = stages * self.w + states
        size = self._c.stage_qp_size(stages, states, controls)
        self._memory = np.zeros(-(-size // 8) + 1)
        address = self._memory.ctypes.data
        handle = self._c.stage_qp_open(stages, states, controls, address)
        super().__init__(self._c.stage_qp_array, handle)

    def solve(self, iterations: int = 60) -> int:
        status: int = self._c.stage_qp_begin(self.handle)
        for _ in range(iterations):
            if status == 1:  # not converged
                status = self._c.stage_qp_iterate(self.handle)
        assert self._memory[-1] == 0.0, "the solver wrote behind its memory"
        return status

    def at(self, stage: int) -> slice:
        """Return the variables x of a stage."""
        begin = stage * self.w + (self.u if stage < self.N else 0)
        return slice(begin, begin + self.x)

    def matrices(self) -> tuple[Any, Any, Any]:
        """Return H, and A v = b of the dynamics and of a fixed start, as dense matrices."""
        H = np.zeros((self.total, self.total))
        A, b = np.zeros((self.N * self.x, self.total)), -self["c"]
        C = self["C"].reshape(self.N, self.x, self.w)
        for k in range(self.N + 1):
            n = self.w if k < self.N else self.x
            own = slice(k * self.w, k * self.w + n)
            part = np.triu(self["H"][k * self.w**2 :][: n * n].reshape(n, n))
            H[own, own] = part + np.triu(part, 1).T
            if k < self.N:
                rows = slice(k * self.x, (k + 1) * self.x)
                A[rows, own], A[rows, self.at(k + 1)] = C[k], -np.eye(self.x)
        start = np.eye(self.total)[self.at(0)]
        return H, np.vstack([A, start]), np.concatenate([b, self["start"]])

    def dense_solution(self) -> Any:
        """Return v of the same program, with slack variables, from DAQP."""
        H, A, b = self.matrices()
        low, high, total = self["low"].copy(), self["high"].copy(), self.total
        penalty = self["penalty"]
        is_soft = penalty > 0
        sides = [(i, -1.0, -low[i]) for i in np.flatnonzero(is_soft & np.isfinite(low))]
        sides += [(i, 1.0, high[i]) for i in np.flatnonzero(is_soft & np.isfinite(high))]
        m = len(sides)
        G, h = np.zeros((m, total + m)), np.zeros(m)
        for row, (i, sign, bound) in enumerate(sides):
            G[row, i], G[row, total + row], h[row] = sign, -1.0, bound
        own = [i for i, _, _ in sides]
        P = np.zeros((total + m, total + m))
        P[:total, :total] = H
        low[is_soft], high[is_soft] = -np.inf, np.inf
        solution = qpsolvers.solve_qp(
            P,
            np.concatenate([self["g"], penalty[own]]),
            *((G, h) if m else (None, None)),
            np.hstack([A, np.zeros((len(A), m))]),
            b,
            np.concatenate([low, np.zeros(m)]),
            np.concatenate([high, np.full(m, np.inf)]),
            solver="daqp",
            primal_tol=1e-12,
            dual_tol=1e-12,
        )
        assert solution is not None
        return solution[:total]


def random_program(seed: int) -> StageProgram:
    """Return a random program with hard bounds of u, soft bounds of x, and many active bounds."""
    rng = np.random.default_rng(seed)
    N, x, u = (int(k) for k in (rng.integers(1, 9), rng.integers(1, 5), rng.integers(1, 5)))
    p, w = StageProgram(N, x, u), x + u
    for k in range(N + 1):
        n = w if k < N else x
        R = rng.normal(size=(n, n))
        p["H"][k * w * w :][: n * n] = np.triu(R @ R.T / n + 1e-2 * np.eye(n)).ravel()
    A = np.eye(x) + 0.1 * rng.normal(size=(N, x, x))
    p["C"][:] = np.concatenate([rng.normal(size=(N, x, u)), A], axis=2).ravel()
    p["g"][:], p["c"][:] = 3.0 * rng.normal(size=p.total), 0.1 * rng.normal(size=N * x)
    p["start"][:] = rng.normal(size=x)
    p["low"][:], p["high"][:] = -0.5, rng.uniform(0.1, 0.5, p.total)
    for k in range(1, N + 1):
        at = p.at(k)
        p["low"][at], p["high"][at] = -1.0, 1.0 if k < N else np.inf
        p["penalty"][at] = rng.uniform(0.5, 30.0)
    p["low"][p.at(0)], p["high"][p.at(0)] = -np.inf, np.inf
    p["tolerance"][:] = 1e-13, 1e-12
    return p
