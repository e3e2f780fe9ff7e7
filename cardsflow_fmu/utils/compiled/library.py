"""Loader of the C library for runs, and the types of its functions."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import CardsflowError

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
_POINTER, _COUNT, _LONG = ctypes.c_void_p, ctypes.c_int32, ctypes.c_int64
_DOUBLE, _SIZE = ctypes.c_double, ctypes.c_size_t
_FUNCTIONS: dict[str, tuple[list[Any], Any]] = {
    "master_open": ([_COUNT, _COUNT, _COUNT], _POINTER),
    "master_close": ([_POINTER], None),
    "master_add_turn": ([_POINTER, _POINTER, _POINTER, _COUNT, _COUNT], None),
    "master_add_copy": (
        [_POINTER, _COUNT, _POINTER, _POINTER, _COUNT, _DOUBLE, _DOUBLE],
        None,
    ),
    "master_add_column": ([_POINTER, _POINTER, _DOUBLE], None),
    "master_set_step": ([_POINTER, _DOUBLE, _COUNT], None),
    "master_set_timer": ([_POINTER, _COUNT, _POINTER], None),
    "master_run": ([_POINTER, _LONG, _LONG, _DOUBLE, _POINTER, _POINTER, _POINTER], _COUNT),
    "master_record": ([_POINTER, _DOUBLE, _POINTER], _COUNT),
    "fmu_row_open": ([_COUNT, _POINTER], _POINTER),
    "fmu_row_close": ([_POINTER], None),
    "fmu_row_add": (
        [_POINTER, _COUNT, _POINTER, _POINTER, _POINTER, _SIZE, _POINTER, _SIZE],
        _COUNT,
    ),
    "fmu_row_get": ([_POINTER], _COUNT),
    "fmu_row_set": ([_POINTER], _COUNT),
    "fmu_open": ([_COUNT, _POINTER, _POINTER, _POINTER, _POINTER], _POINTER),
    "fmu_close": ([_POINTER], None),
    "fmu_step": ([_POINTER, _DOUBLE, _DOUBLE], _COUNT),
}
"""Functions of cosim/csrc by name: arguments and result."""


@cache
def run_library() -> ctypes.CDLL:
    """Load the library. Its calls release Python's global interpreter lock."""
    root = Path(os.environ.get("CARDSFLOW_LIBRARY_DIR") or Path(__file__).parents[3])
    path = root / "cardsflow_fmu" / "runtime" / "lib" / f"cardsflow_run{_SUFFIX}"
    if not path.is_file():
        problem = "the C library for runs is missing; install the package again"
        raise CardsflowError(f"{path}: {problem}, or run `python hatch_build.py` in a source tree")
    library = ctypes.CDLL(str(path))
    for name, (arguments, result) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, result
    return library


def address(function: Any) -> int:
    """Return the address of a C function or callback."""
    value = ctypes.cast(function, ctypes.c_void_p).value
    assert value is not None
    return value
