"""FMI 2.0 and FMI 3.0 calls of a co-simulation through one interface.

FMPy loads and instantiates an FMU; csrc/fmu_step.c calls its functions in each step. Each call
returns FMI's status.
"""

from __future__ import annotations

import ctypes
import weakref
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import fmpy.fmi1
import fmpy.fmi2
import fmpy.fmi3

from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.compiled.library import address, run_library

from .fmu_variables import Row, type_number

DISCARD = 2
"""Lowest status that means failure."""

Log = Callable[[int, str], None]
"""Function that receives the status and the text of a message."""


class FmuCalls(ABC):
    """Calls of an FMU instance.

    Raises:
        Exception: FMPy cannot load the library, or the FMU cannot be instantiated.
    """

    _prefix: str
    _version: int

    def __init__(self, name: str, description: Any, folder: Path, log: Log) -> None:
        self._log = log
        self._slave = self._instantiate(name, description, folder)
        self._library = self._slave.dll
        self._instance = ctypes.c_void_p(self._slave.component)
        self._buffers: list[FloatArray] = []  # memory that the rows in C use

    @abstractmethod
    def _instantiate(self, name: str, description: Any, folder: Path) -> Any: ...

    def enter_configuration(self) -> int:
        """Enter the mode in which structural parameters of FMI 3.0 can be set."""
        return self._call("EnterConfigurationMode")

    def exit_configuration(self) -> int:
        """Leave the mode for structural parameters."""
        return self._call("ExitConfigurationMode")

    @abstractmethod
    def enter_initialization(self) -> int:
        """Enter the initialization mode without a stop time.

        The last tick of a slower controller may extend beyond the end of the run.
        """

    def exit_initialization(self) -> int:
        """Leave the initialization mode."""
        return self._call("ExitInitializationMode")

    def terminate(self) -> int:
        """End the simulation, so that the FMU releases its resources."""
        return self._call("Terminate")

    def row(self, row: Row) -> ctypes.c_void_p:
        """Return the variables of a row in C; see `fmu_row` in csrc/fmu_step.h."""
        library = run_library()
        handle = ctypes.c_void_p(library.fmu_row_open(self._version, self._instance))
        weakref.finalize(self, library.fmu_row_close, handle)
        self._buffers.append(row.values)
        for bank in row.banks:
            values, count = row.values[bank.place], len(bank.references)
            references = (ctypes.c_uint32 * count)(*bank.references)
            get, set_ = (self._address(f"{verb}{bank.function}") for verb in ("Get", "Set"))
            kind = type_number(self._version, bank.function)
            failed = library.fmu_row_add(
                *(handle, kind, get, set_, references, count, values.ctypes.data, values.size)
            )
            assert not failed, "not enough memory"
        return handle

    def stepper(self, inputs: ctypes.c_void_p, outputs: ctypes.c_void_p) -> ctypes.c_void_p:
        """Return the instance for the function `fmu_step` in C, with the rows of a step in C."""
        library, do_step = run_library(), self._address("DoStep")
        handle = library.fmu_open(self._version, self._instance, do_step, inputs, outputs)
        fmu = ctypes.c_void_p(handle)
        weakref.finalize(self, library.fmu_close, fmu)
        return fmu

    def free(self) -> None:
        """Free the instance. Its library stays loaded because other instances may use it."""
        function = self._library[f"{self._prefix}FreeInstance"]
        function.restype = None
        function(self._instance)

    def _address(self, name: str) -> int:
        return address(self._library[self._prefix + name])

    def _call(self, name: str, *arguments: Any) -> int:
        return int(self._library[self._prefix + name](self._instance, *arguments))


class Fmi2Calls(FmuCalls):
    """Calls of an FMI 2.0 instance."""

    _prefix, _version = "fmi2", 2

    def _instantiate(self, name: str, description: Any, folder: Path) -> Any:
        callbacks = fmpy.fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(self._on_log)
        callbacks.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        slave = fmpy.fmi2.FMU2Slave(
            instanceName=name,
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=str(folder),
        )
        slave.instantiate(callbacks=callbacks)
        return slave

    def _on_log(
        self, _: int | None, instance: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        """Forward a message; replace FMI 2's doubled `%` and `#`.

        FMPy's formatting proxy is not used because it supports one logger per process.
        """
        text = message.decode("utf-8", "replace")
        self._log(status, text.replace("%%", "%").replace("##", "#"))

    def enter_initialization(self) -> int:  # noqa: D102
        zero, none = ctypes.c_double(0.0), ctypes.c_int(0)
        status = self._call("SetupExperiment", none, zero, zero, none, zero)
        return status if status >= DISCARD else self._call("EnterInitializationMode")


class Fmi3Calls(FmuCalls):
    """Calls of an FMI 3.0 instance."""

    _prefix, _version = "fmi3", 3

    def _instantiate(self, name: str, description: Any, folder: Path) -> Any:
        slave = fmpy.fmi3.FMU3Slave(
            instanceName=name,
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=str(folder),
        )
        slave.instantiate(logMessage=self._on_log)
        return slave

    def _on_log(self, _: int | None, status: int, category: bytes, message: bytes) -> None:
        self._log(status, message.decode("utf-8", "replace"))

    def enter_initialization(self) -> int:  # noqa: D102
        zero, none = ctypes.c_double(0.0), ctypes.c_bool(False)
        return self._call("EnterInitializationMode", none, zero, zero, none, zero)
