"""Distribution of items over threads that call the C core."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

MAX_THREADS = 8


class Threads:
    """Threads that share items 0, 1, ..., n - 1 in contiguous parts.

    Functions must release Python's global interpreter lock, as functions of a `ctypes.CDLL` do.

    Args:
        count: Number of threads (default: number of processors, at most 8).

    Attributes:
        count: Number of threads.
    """

    def __init__(self, count: int = 0) -> None:
        self.count = count or min(os.cpu_count() or 1, MAX_THREADS)
        self._pool: ThreadPoolExecutor | None = None

    def share(self, run: Callable[[int, slice], None], items: int, is_small: bool) -> None:
        """Call `run(thread, part)` for each part of the items.

        Args:
            run: Function of the index of the thread and of the part.
            items: Number of items.
            is_small: Whether the work is too small for several threads.
        """
        if is_small or self.count == 1:
            run(0, slice(0, items))
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self.count)
        ends = [items * k // self.count for k in range(self.count + 1)]
        parts = [slice(a, b) for a, b in pairwise(ends)]
        others = [self._pool.submit(run, k, part) for k, part in enumerate(parts[1:], 1)]
        run(0, parts[0])
        for future in others:
            future.result()
