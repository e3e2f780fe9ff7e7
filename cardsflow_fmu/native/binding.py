"""The binding of the loop in C, native_loop.h."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

from cardsflow_fmu.runtime.library import library_path


@cache
def native_library() -> ctypes.CDLL:
    """The library of the FMUs, whose calls let go of Python's lock.

    Raises:
        InputError: There is no library.
    """
    library = ctypes.CDLL(str(library_path()))
    pointer, count, size = ctypes.c_void_p, ctypes.c_int32, ctypes.c_size_t
    library.native_loop_open.argtypes = [count, pointer, ctypes.c_char_p, size]
    library.native_loop_open.restype = pointer
    library.native_loop_close.argtypes = [pointer]
    library.native_loop_close.restype = None
    library.native_loop_values.argtypes = [pointer, count, pointer]
    library.native_loop_values.restype = ctypes.POINTER(ctypes.c_double)
    library.native_loop_layout.argtypes = [count]
    library.native_loop_layout.restype = ctypes.c_char_p
    library.native_loop_layout_hash.argtypes = [count]
    library.native_loop_layout_hash.restype = ctypes.c_uint32
    table: list[Any] = [count, pointer]
    library.native_loop_plan.argtypes = [pointer, *table, *table, pointer, *table, *table]
    library.native_loop_initialize.argtypes = [pointer]
    double, long = ctypes.c_double, ctypes.c_int64
    library.native_loop_run.argtypes = [pointer, double, long, long, pointer, pointer, pointer]
    library.native_loop_record.argtypes = [pointer, ctypes.c_double, pointer]
    library.native_loop_record.restype = None
    library.native_loop_message.argtypes = [pointer]
    library.native_loop_message.restype = ctypes.c_char_p
    return library
