"""Model for tests of worker processes that misbehaves on request."""

from __future__ import annotations

import ctypes
import os
import time
from pathlib import Path
from typing import Self

from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.runtime.model import FloatArray, FmuModel

WELL, SLEEP, EXIT, CRASH, RAISE, HOLD = range(6)

PORTS = (
    Port("u", "", "input", "continuous", "Summed up"),
    Port("sum", "", "output", "continuous", "Of u"),
    Port("process", "", "output", "discrete", "Number of the process"),
    Port("action", "", "parameter", "tunable", "What to do in a step"),
    Port("state_size", "", "parameter", "tunable", "Bytes of state beyond the sum"),
    Port("worker_timeout", "s", "parameter", "tunable", "Longest call of a worker process", 60.0),
)
REFERENCES = {port.name: reference for reference, port in enumerate(PORTS)}


class StubbornModel(FmuModel):
    """Model that sums its input."""

    def __init__(self, factor: float, values: FloatArray | None = None) -> None:
        super().__init__(PORTS, values)
        self._factor = factor
        self._memory = b""

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        return cls(float((folder / "factor.txt").read_text("utf-8")), values)

    def initialize(self, t: float = 0.0) -> None:
        self.outputs[:] = 0.0, os.getpid()

    def step(self, t: float, h: float) -> None:
        action = int(self.parameters[0])
        if action == SLEEP:
            time.sleep(1e6)
        elif action == EXIT:
            os._exit(7)
        elif action == CRASH:
            ctypes.string_at(0)
        elif action == RAISE:
            raise RuntimeError("as asked")
        elif action == HOLD:
            ctypes.PyDLL(None).pause()  # while it holds Python's lock
        self.outputs[0] += self._factor * self.inputs[0]

    def get_state(self) -> bytes:
        size = int(self.parameters[1])
        return self.outputs[:1].tobytes() + bytes(k % 251 for k in range(size))

    def set_state(self, state: bytes) -> None:
        size = int(self.parameters[1])
        assert state[8:] == bytes(k % 251 for k in range(size))
