"""Sparse matrices with a fixed pattern."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix

from controllers.arrays import FloatArray, IntArray


class SparsePattern:
    """Sparse matrix with fixed places of its entries, filled many times."""

    def __init__(self, rows: list[IntArray], columns: list[IntArray], shape: tuple[int, int]):
        i, j = (np.concatenate([np.ravel(k) for k in part]) for part in (rows, columns))
        order = csc_matrix((np.arange(1.0, len(i) + 1), (i, j)), shape=shape)
        self._order = order.data.astype(int) - 1
        self._parts = order.indices, order.indptr
        self._shape = shape

    def fill(self, *values: FloatArray) -> csc_matrix:
        """Return the matrix with entries in the order of the places."""
        data = np.concatenate([np.ravel(part) for part in values])[self._order]
        return csc_matrix((data, *self._parts), shape=self._shape)
