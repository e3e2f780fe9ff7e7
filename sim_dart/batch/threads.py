"""Distribution of items over threads that call the C core."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

MAX_THREADS = 8


class Threads:
    """Threads that share items 0, 1, ..., n - 1 in contiguous parts, each taken by a free thread.

    Functions must release Python's global interpreter lock, as functions of a `ctypes.CDLL` do.

    Args:
        count: Number of threads (default: number of processors, at most 8).
        parts: Number of parts per thread; several if some items take longer than others.

    Attributes:
        count: Number of threads.
    """

    def __init__(self, count: int = 0, parts: int = 1) -> None:
        self.count = count or min(os.cpu_count() or 1, MAX_THREADS)
        self._parts = self.count * parts
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
        ends = [items * k // self._parts for k in range(self._parts + 1)]
        parts = iter([slice(a, b) for a, b in pairwise(ends)])

        def work(thread: int) -> None:
            for part in parts:
                run(thread, part)

        others = [self._pool.submit(work, k) for k in range(1, self.count)]
        work(0)
        for future in others:
            future.result()
