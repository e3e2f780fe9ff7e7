"""The binding of native_loop.h, and the opening of its models."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence

from addin_sdfusion.robot import CardsflowError, InputError
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.runtime.port_table import encode_port_table
from cardsflow_fmu.signals.ports import Port
from cardsflow_fmu.signals.variables import scalar_variables
from cardsflow_fmu.utils.temporary import temporary_folder
from cardsflow_fmu.version import __version__

from .binding import native_library
from .model_file import NATIVE_FILE, native_model

_INSTEAD = 'run it as FMUs (without --native; in a study with engine = "fmu")'


def native_models(experiment: Experiment, names: Sequence[str]) -> dict[str, bytes]:
    """The models in C, as their files hold them.

    Raises:
        InputError: It has something that is not in C, which the message names, or is wrong.
    """
    lacking = _lacking(experiment, names)
    if lacking is not None:
        raise InputError(f"a native loop does not have {lacking}; {_INSTEAD}", file=experiment.file)
    return {name: native_model(experiment, name, _INSTEAD).contents for name in names}


def _lacking(experiment: Experiment, names: Sequence[str]) -> str | None:
    """Another part of the run than the models that is not in C; None if there is none."""
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
    with temporary_folder() as aside:
        folders = []
        for name, ports in tables.items():
            folder = aside / name
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
