"""FMI 2.0 and FMI 3.0 calls of a co-simulation through one interface.

FMPy loads and instantiates an FMU; the calls of a step go to its library directly, since FMPy
creates new arrays in every call. Each call returns FMI's status.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import fmpy
import fmpy.fmi1
import fmpy.fmi2
import fmpy.fmi3

from .fmu_variables import Bank, Row

DISCARD = 2
"""Lowest status that means failure."""

Log = Callable[[int, str], None]
"""Function that receives the status and the text of a message."""


class FmuCalls(ABC):
    """Calls of an FMU instance.

    Args:
        name: Name of the instance.
        description: FMPy's model description.
        folder: Folder with the unpacked FMU.
        log: Function that receives the FMU's messages.

    Raises:
        Exception: FMPy cannot load the library, or the FMU cannot be instantiated.
    """

    _prefix: str

    def __init__(self, name: str, description: Any, folder: Path, log: Log) -> None:
        self._log = log
        self._slave = self._instantiate(name, description, folder)
        self._library = self._slave.dll
        self._instance = ctypes.c_void_p(self._slave.component)

    @abstractmethod
    def _instantiate(self, name: str, description: Any, folder: Path) -> Any: ...

    @abstractmethod
    def _arguments(self, bank: Bank) -> tuple[Any, ...]:
        """Return the arguments of a getter or setter."""

    @abstractmethod
    def enter_initialization(self) -> int:
        """Set up the experiment and enter the initialization mode."""

    @abstractmethod
    def step(self, t: float, h: float) -> int:
        """Advance from t to t + h, in [s]."""

    def exit_initialization(self) -> int:
        """Leave the initialization mode."""
        return self._call("ExitInitializationMode")

    def terminate(self) -> int:
        """End the simulation, so that the FMU releases its resources."""
        return self._call("Terminate")

    def getter(self, row: Row) -> Callable[[], int]:
        """Return a function that reads all variables of a row into its buffers."""
        return self._combined_call("Get", row.banks)

    def setter(self, row: Row) -> Callable[[], int]:
        """Return a function that writes all variables of a row from its buffers."""
        return self._combined_call("Set", row.banks)

    def free(self) -> None:
        """Free the instance. Its library stays loaded because other instances may use it."""
        function = self._library[f"{self._prefix}FreeInstance"]
        function.restype = None
        function(self._instance)

    def _combined_call(self, verb: str, banks: Sequence[Bank]) -> Callable[[], int]:
        """Return a function that gets or sets all banks and returns the highest status."""
        functions = [
            (self._library[f"{self._prefix}{verb}{bank.function}"], self._arguments(bank))
            for bank in banks
        ]
        # `partial` is implemented in C, which makes these calls fast.
        calls = [partial(function, *arguments) for function, arguments in functions]
        if not calls:
            return int  # returns 0
        if len(calls) == 1:
            return calls[0]
        if len(calls) == 2:
            first, second = calls
            return lambda: max(first(), second())
        return lambda: max((call() for call in calls), default=0)

    def _call(self, name: str, *arguments: Any) -> int:
        return int(self._library[self._prefix + name](self._instance, *arguments))


class Fmi2Calls(FmuCalls):
    """Calls of an FMI 2.0 instance."""

    _prefix = "fmi2"

    def __init__(self, name: str, description: Any, folder: Path, log: Log) -> None:
        super().__init__(name, description, folder, log)
        self._do_step = self._library["fmi2DoStep"]
        self._do_step.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_double,
            ctypes.c_int,
        ]

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

    def _arguments(self, bank: Bank) -> tuple[Any, ...]:
        return self._instance, bank.references, ctypes.c_size_t(bank.count), bank.buffer

    def enter_initialization(self) -> int:
        """Enter the initialization mode without a stop time.

        The last tick of a slower controller may extend beyond the end of the run.
        """
        zero, none = ctypes.c_double(0.0), ctypes.c_int(0)
        status = self._call("SetupExperiment", none, zero, zero, none, zero)
        return status if status >= DISCARD else self._call("EnterInitializationMode")

    def step(self, t: float, h: float) -> int:
        """Advance from t to t + h, in [s]."""
        status: int = self._do_step(self._instance, t, h, 1)
        return status


class Fmi3Calls(FmuCalls):
    """Calls of an FMI 3.0 instance."""

    _prefix = "fmi3"

    def __init__(self, name: str, description: Any, folder: Path, log: Log) -> None:
        super().__init__(name, description, folder, log)
        self._flags = [ctypes.c_bool() for _ in range(3)]
        self._time = ctypes.c_double()
        self._outs = (*map(ctypes.byref, self._flags), ctypes.byref(self._time))
        self._do_step = self._library["fmi3DoStep"]
        self._do_step.argtypes = [
            ctypes.c_void_p,
            ctypes.c_double,
            ctypes.c_double,
            ctypes.c_bool,
            *[ctypes.c_void_p] * 4,
        ]

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

    def _arguments(self, bank: Bank) -> tuple[Any, ...]:
        count, size = ctypes.c_size_t(bank.count), ctypes.c_size_t(len(bank.buffer))
        return self._instance, bank.references, count, bank.buffer, size

    def enter_initialization(self) -> int:
        """Enter the initialization mode without a stop time.

        The last tick of a slower controller may extend beyond the end of the run.
        """
        zero, none = ctypes.c_double(0.0), ctypes.c_bool(False)
        return self._call("EnterInitializationMode", none, zero, zero, none, zero)

    def step(self, t: float, h: float) -> int:
        """Advance from t to t + h, in [s]. A request of the FMU to terminate is a failure."""
        status: int = self._do_step(self._instance, t, h, True, *self._outs)
        if status < DISCARD and self._flags[1].value:
            self._log(DISCARD, "the FMU requested to terminate the simulation")
            return DISCARD
        return status
