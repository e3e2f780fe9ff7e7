"""Binding of the C functions in opened_model.h."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from cardsflow_fmu.runtime.library import library_path


@cache
def native_library() -> ctypes.CDLL:
    """Load the library of FMUs. Its calls release the Python lock (GIL)."""
    library = ctypes.CDLL(str(library_path()))
    pointer, count, size = ctypes.c_void_p, ctypes.c_int32, ctypes.c_size_t
    double, text = ctypes.c_double, ctypes.c_char_p
    functions: dict[str, tuple[list[Any], Any]] = {
        "native_model_layout": ([count], text),
        "native_model_layout_hash": ([count], ctypes.c_uint32),
        "native_model_open": ([text, size, text, size, pointer, text, size], pointer),
        "native_model_close": ([pointer], None),
        "native_model_initialize": ([pointer, double], count),
        "native_model_step": ([pointer, double, double], count),
        "native_model_get_state": ([pointer, pointer, pointer], count),
        "native_model_set_state": ([pointer, text, size], count),
        "native_model_use": ([pointer, pointer, pointer], count),
        "native_model_array": ([pointer, text, pointer], pointer),
        "native_model_message": ([pointer], text),
    }
    for name, (arguments, result) in functions.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, result
    return library
