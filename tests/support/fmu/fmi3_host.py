"""Adapter of FMPy's FMI 3.0 slave to the interface of its FMI 2.0 slave, for common tests."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from fmpy import fmi3


class FMU3SlaveAs2(fmi3.FMU3Slave):
    """FMI 3.0 instance with the methods of an FMI 2.0 instance."""

    def setupExperiment(self, startTime: float = 0.0, stopTime: float | None = None) -> None:
        self.times = startTime, stopTime

    def enterInitializationMode(self) -> None:
        start, stop = self.times
        super().enterInitializationMode(startTime=start, stopTime=stop)

    def getReal(self, references: Sequence[int]) -> list[float]:
        return list(self.getFloat64(references))

    def setReal(self, references: Sequence[int], values: Sequence[float]) -> None:
        self.setFloat64(references, values)

    def getRealStatus(self, kind: int) -> float:
        """Return the time; its reference follows those of the ports of the toy model."""
        (time,) = self.getFloat64([10])
        return float(time)

    def getFMUstate(self) -> Any:
        return self.getFMUState()

    def setFMUstate(self, state: Any) -> None:
        self.setFMUState(state)

    def freeFMUstate(self, state: Any) -> None:
        self.freeFMUState(state)

    def serializeFMUstate(self, state: Any) -> bytes:
        return bytes(self.serializeFMUState(state))

    def deSerializeFMUstate(self, data: bytes) -> Any:
        return self.deserializeFMUState(data)

    def fmi2GetFMUstate(self, component: Any, state: Any) -> int:
        return int(self.fmi3GetFMUState(component, state))

    def fmi2SerializeFMUstate(self, component: Any, state: Any, room: Any, size: int) -> int:
        room = ctypes.cast(room, ctypes.POINTER(fmi3.fmi3Byte))
        return int(self.fmi3SerializeFMUState(component, state, room, size))
