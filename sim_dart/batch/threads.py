"""Distribution of items over threads that call the C core."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np

MAX_THREADS = 8


class Threads:
    """Threads that share items 0, 1, ..., n - 1 in contiguous parts.

    Functions must release Python's global interpreter lock, as functions of a `ctypes.CDLL` do.

    Args:
        count: Number of threads (default: number of processors, at most 8).
        is_balanced: Whether parts have sizes with which all threads took the same time the last
            time; otherwise they have the same size.

    Attributes:
        count: Number of threads.
    """

    def __init__(self, count: int = 0, is_balanced: bool = False) -> None:
        self.count = count or min(os.cpu_count() or 1, MAX_THREADS)
        self._pool: ThreadPoolExecutor | None = None
        self._is_balanced, self._ends = is_balanced, np.linspace(0.0, 1.0, self.count + 1)

    def share(self, run: Callable[[int, slice], None], items: int, is_small: bool) -> None:
        """Call `run(thread, part)` for each part of the items.

        Args:
            run: Function of the index of the thread and of the part.
            is_small: Whether the work is too small for several threads.
        """
        if is_small or self.count == 1:
            run(0, slice(0, items))
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self.count)
        ends = np.floor(items * self._ends + 1e-9).astype(int).tolist()
        parts = [slice(a, b) for a, b in pairwise(ends)]
        seconds = np.zeros(self.count)

        def run_timed(thread: int, part: slice) -> None:
            began = time.thread_time()
            run(thread, part)
            seconds[thread] = time.thread_time() - began

        others = [self._pool.submit(run_timed, k, part) for k, part in enumerate(parts[1:], 1)]
        run_timed(0, parts[0])
        for future in others:
            future.result()
        if self._is_balanced and seconds.min() > 0.0:
            used = np.cumsum([0.0, *seconds])
            self._ends = np.interp(np.linspace(0.0, used[-1], len(used)), used, self._ends)
