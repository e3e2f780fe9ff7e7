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
    for name in ("step", "reset", "terms", "derivatives"):
        getattr(core, f"core_batch_{name}").restype = None
    part: list[Any] = [pointer, count, count]
    core.core_episodes_start.argtypes = [*part, pointer]
    core.core_episodes_step.argtypes = [*part, *6 * [pointer]]
    core.core_episodes_evaluate.argtypes = [*part, *4 * [pointer]]
    for name in ("start", "step", "evaluate"):
        getattr(core, f"core_episodes_{name}").restype = None
    return core


def _fields(kind: Any, names: str) -> list[tuple[str, Any]]:
    return [(name, kind) for name in names.split()]


EPISODE_FIELDS: Any = [
    *_fields(ctypes.c_void_p, "memory"),
    *_fields(ctypes.c_size_t, "stride"),
    *_fields(ctypes.c_int32, "instances width"),
    *_fields(ctypes.c_void_p, "streams ticks targets q commands torques answers variants moving"),
    *_fields(ctypes.c_void_p, "target_low target_high points q_low q_high"),
    *_fields(ctypes.c_int32, "draws_targets draws_q point_count blob_count"),
    *_fields(ctypes.c_void_p, "blobs blob_sizes zeros rest activation_columns"),
    *_fields(ctypes.c_int32, "activations reference_rows"),
    *_fields(ctypes.c_void_p, "reference"),
    *_fields(ctypes.c_double, "activation"),
    *_fields(ctypes.c_void_p, "actions"),
    *_fields(ctypes.c_int32, "action_count is_sigmoid"),
    *_fields(ctypes.c_double, "h"),
    *_fields(ctypes.c_int32, "steps is_runge_kutta"),
    *_fields(ctypes.c_void_p, "features"),
    *_fields(ctypes.c_int32, "feature_count first_end"),
    *_fields(ctypes.c_double, "near beyond far"),
    ("weights", 4 * ctypes.c_double),
    *_fields(ctypes.c_double, "last"),
]
"""Fields of `episodes` in episodes.h."""
