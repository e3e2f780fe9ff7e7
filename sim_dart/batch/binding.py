"""Binding of the functions of the C core for many instances."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from sim_dart.core.library import library

MASS_MATRIX, BIAS, TASK_JACOBIAN, TENSIONS = 1, 2, 4, 8
"""Terms of `enum batch_term`."""


@cache
def batch_library() -> Any:
    """Return the C core, with functions that release the global interpreter lock."""
    core = ctypes.CDLL(library()._name)
    pointer, size, count = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int32
    real = ctypes.c_double
    instances: list[Any] = [pointer, size, count]
    core.core_batch_group_size.argtypes, core.core_batch_group_size.restype = [pointer], size
    rule: list[Any] = [real, count, count]
    core.core_batch_step.argtypes = [*instances, *3 * [pointer], *rule, pointer, pointer]
    core.core_batch_reset.argtypes = [*instances, pointer, pointer, pointer, pointer, pointer]
    core.core_batch_terms.argtypes = [*instances, count, pointer]
    core.core_batch_derivatives_size.argtypes = [pointer]
    core.core_batch_derivatives_size.restype = size
    inputs: list[Any] = [count, pointer]
    core.core_batch_derivatives.argtypes = [
        *(*instances, pointer, pointer, pointer, real, count, count, *inputs, pointer, pointer)
    ]
    core.core_batch_features.argtypes = [
        *(*instances, count, pointer, count, pointer, pointer, pointer, pointer)
    ]
    for name in ("step", "reset", "terms", "features", "derivatives"):
        getattr(core, f"core_batch_{name}").restype = None
    return core
