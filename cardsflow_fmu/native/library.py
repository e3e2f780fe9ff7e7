"""The binding of native_loop.h, and the opening of its models."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.runtime.library import library_path
from cardsflow_fmu.runtime.port_table import encode_port_table
from cardsflow_fmu.signals.ports import Port
from cardsflow_fmu.signals.variables import scalar_variables
from cardsflow_fmu.version import __version__

from .model_file import NATIVE_FILE, native_model

_INSTEAD = 'run it as FMUs (without --native; in a study with engine = "fmu")'


def native_models(experiment: Experiment, names: Sequence[str]) -> dict[str, bytes]:
    """The models in C, as their files hold them.

    Raises:
        InputError: It has something that is not in C; the message names it.
    """
    lacking = _lacking(experiment, names)
    if lacking is not None:
        raise InputError(f"a native loop does not have {lacking}; {_INSTEAD}", file=experiment.file)
    try:
        return {name: native_model(experiment, name).contents for name in names}
    except InputError as error:
        what = error.what.partition(";")[0]  # behind it stands what to build instead
        raise InputError(f"{what}; {_INSTEAD}", file=error.file, key=error.key) from None


def _lacking(experiment: Experiment, names: Sequence[str]) -> str | None:
    """What else than the models themselves is not in C."""
    if experiment.hardware.use:
        return "hardware"
    external = [name for name in names if name in experiment.fmus]
    if external:
        return f"external FMUs ({', '.join(external)})"
    engines = {"plant": experiment.plant.engine, "controller": experiment.controller.engine}
    in_dart = [name for name, engine in engines.items() if engine == "dart"]
    named = ", ".join(f"{role}.engine" for role in in_dart)
    return f'the engine "dart" ({named})' if in_dart else None


def opened_loop(
    files: Mapping[str, bytes], tables: Mapping[str, Sequence[Port]], step: float
) -> ctypes.c_void_p:
    """The models opened in C, at their start values.

    Args:
        files: From `native_models`.
        tables: The variables of each, in the same order.
        step: Communication step, in [s].

    Raises:
        CardsflowError: The library refuses a model.
    """
    library = native_library()
    with tempfile.TemporaryDirectory() as aside:
        folders = []
        for name, ports in tables.items():
            folder = Path(aside) / name
            folder.mkdir()
            (folder / NATIVE_FILE).write_bytes(files[name])
            record = encode_port_table(
                scalar_variables(ports), guid="", model_name=name, package=__version__, step=step
            )
            (folder / "ports.bin").write_bytes(record)
            folders.append(str(folder).encode())
        paths = (ctypes.c_char_p * len(folders))(*folders)
        message = ctypes.create_string_buffer(512)
        loop = library.native_loop_open(len(folders), paths, message, len(message))
    if not loop:
        raise CardsflowError(f"the native loop: {message.value.decode('utf-8', 'replace')}")
    return ctypes.c_void_p(loop)


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
