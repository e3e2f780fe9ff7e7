"""Paths around obstacles, as guesses of motions: random trees of poses that grow together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cardsflow_fmu.utils.arrays import FloatArray
from controllers.arrays import BoolArray
from controllers.optimal.problem import Iterate, NodeConstraint, OptimalProblem, excess
from controllers.optimal.sqp import INTERRUPTED, Optimiser

from .segments import SegmentDistances

ROUGH = 1e-3  # tolerance of guesses
_PATHS = 4  # with different random numbers
_MAX_POSES = 20_000  # checked poses of one path
_STEP = 0.7  # largest motion of a segment between two poses, relative to its least distance
_SHORTCUTS = 200
_SMOOTHINGS = 3


def without_obstacles(problem: OptimalProblem) -> OptimalProblem:
    """Return a problem with its goals, and without constraints of the path."""
    goals = [each for each in problem.constraints if len(each.nodes) == 1]
    return replace(problem, constraints=goals)


def rough_motion(problem: OptimalProblem, guess: Iterate) -> Iterate | None:
    """Return a nearly optimal motion; None if none is found."""
    solution = Optimiser(problem, tolerance=ROUGH).solve(guess)
    if solution is not None and solution.status == INTERRUPTED:
        raise KeyboardInterrupt
    return None if solution is None or not solution.is_feasible else solution.iterate


def detours(problem: OptimalProblem, free: Iterate, n: int) -> Iterator[Iterate]:
    """Yield motions around the obstacles through the goals of another motion, shortest paths first.

    Args:
        problem: The problem.
        free: The motion that ignores the obstacles.
        n: Number of coordinates, which are the first states.
    """
    paths = [each for each in problem.constraints if len(each.nodes) > 1 and each.shares is None]
    fixed = np.flatnonzero((problem.x_low == problem.x_high)[:, :n].all(axis=1))
    goals = [int(each.nodes[0]) for each in problem.constraints if len(each.nodes) == 1]
    nodes = sorted({0, *fixed.tolist(), *goals, problem.intervals})
    motions = list[tuple[float, Iterate]]()
    for seed in range(_PATHS):
        poses = _Poses(problem, paths, free, n, np.random.default_rng(seed))
        x, N, length = free.x.copy(), problem.intervals, 0.0
        for a, b in pairwise(nodes):
            path = poses.path(free.x[a, :n], free.x[b, :n])
            if path is None:
                break
            length += float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
            x[a : b + 1, :n] = _timed(path, b - a + 1)
        else:
            x[:, n : 2 * n] = np.gradient(x[:, :n], free.duration / N, axis=0)
            motions.append((length, free._replace(x=x)))
            continue
        break
    yield from (motion for _, motion in sorted(motions, key=lambda pair: pair[0]))


class _Poses:
    """Poses without violated path constraints.

    Args:
        problem: The problem.
        paths: Its path constraints.
        free: The motion that ignores the obstacles.
        n: Number of coordinates.
        rng: Random numbers.
    """

    def __init__(
        self,
        problem: OptimalProblem,
        paths: Sequence[NodeConstraint],
        free: Iterate,
        n: int,
        rng: np.random.Generator,
    ) -> None:
        self._paths, self._n, self._rng, self._left = paths, n, rng, _MAX_POSES
        self._nx, q = free.x.shape[1], free.x[:, :n]
        low, high = q.min(axis=0), q.max(axis=0)
        limits = problem.x_low[1:-1, :n].max(axis=0), problem.x_high[1:-1, :n].min(axis=0)
        reach = 2.0 * float((high - low).max())
        self._low = np.where(np.isfinite(limits[0]), limits[0], low - reach)
        self._high = np.where(np.isfinite(limits[1]), limits[1], high + reach)
        steps = [0.1 * float((high - low).max())]
        for path in paths:
            if isinstance(path.evaluate, SegmentDistances):
                slopes = path.evaluate.nearest(q)[1]
                fastest = np.linalg.norm(slopes, axis=(2, 3)).max()
                steps.append(_STEP * float(path.low.min()) / max(float(fastest), 1e-9))
        self._step = min(steps)

    def path(self, start: FloatArray, end: FloatArray) -> FloatArray | None:
        """Return poses from a start to an end; None if no path is found."""
        self._left = _MAX_POSES
        if not self._are_free(np.array([start, end])).all():
            return None
        if self._is_open(start, end):
            return np.array([start, end])
        trees = [([start], [-1]), ([end], [-1])]
        while self._left > 0:
            target = self._rng.uniform(self._low, self._high)
            new = self._grow(trees[0], target)
            other = self._grow(trees[1], trees[0][0][new])
            if np.array_equal(trees[1][0][other], trees[0][0][new]):
                halves = [_branch(*pair) for pair in zip(trees, (new, other), strict=True)]
                if not np.array_equal(halves[0][0], start):
                    halves.reverse()
                return self._shortened([*halves[0], *halves[1][::-1]])
            trees.reverse()
        return None

    def _grow(self, tree: tuple[list[FloatArray], list[int]], target: FloatArray) -> int:
        """Add poses to a tree from its nearest one towards a target; return the last index."""
        poses, parents = tree
        nearest = int(((np.array(poses) - target) ** 2).sum(axis=1).argmin())
        line = self._line(poses[nearest], target)[1:]
        for pose in line[: np.argmin([*self._are_free(line), False])]:
            poses.append(pose)
            parents.append(nearest)
            nearest = len(poses) - 1
        return nearest

    def _shortened(self, path: list[FloatArray]) -> FloatArray:
        """Return a path without needless poses."""
        for _ in range(_SHORTCUTS):
            if len(path) < 3:
                break
            i, j = sorted(self._rng.integers(0, len(path), 2).tolist())
            if j - i > 1 and self._is_open(path[i], path[j]):
                path = [*path[: i + 1], *path[j:]]
        return np.array(path)

    def _is_open(self, a: FloatArray, b: FloatArray) -> bool:
        """Return whether all poses on a line are free."""
        return bool(self._are_free(self._line(a, b)).all())

    def _line(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return poses on a line, with both ends."""
        count = int(np.ceil(np.linalg.norm(b - a) / self._step)) + 1
        return np.linspace(a, b, count)

    def _are_free(self, q: FloatArray) -> BoolArray:
        """Return whether each pose satisfies the constraints, shape (k,)."""
        self._left -= len(q)
        x = np.zeros((len(q), self._nx))
        x[:, : self._n] = q
        free = np.ones(len(q), dtype=bool)
        for path in self._paths:
            free &= (excess(path.evaluate(x)[0], path.low, path.high) == 0.0).all(axis=1)
        return free


def _branch(tree: tuple[list[FloatArray], list[int]], k: int) -> list[FloatArray]:
    """Return the poses from the root of a tree to one of its poses."""
    poses, parents = tree
    branch = list[FloatArray]()
    while k >= 0:
        branch.append(poses[k])
        k = parents[k]
    return branch[::-1]


def _timed(path: FloatArray, count: int) -> FloatArray:
    """Return poses at equal distances in time, with minimum jerk along a path."""
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    s = np.linspace(0.0, 1.0, count)
    at = lengths[-1] * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    poses = np.array([np.interp(at, lengths, column) for column in path.T]).T
    for _ in range(_SMOOTHINGS):
        poses[1:-1] = 0.25 * (poses[:-2] + poses[2:]) + 0.5 * poses[1:-1]
    return poses
