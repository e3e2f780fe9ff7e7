"""Small model with arrays, for tests of the runtime."""

from __future__ import annotations

from pathlib import Path
from typing import Self

import numpy as np

from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.runtime.model import FloatArray, FmuModel

PORTS = (
    Port("u.a", "N", "input", "continuous", "Force on a"),
    Port("u.b", "N", "input", "continuous", "Force on b", 0.5),
    Port("on.a", "", "input", "discrete", "Whether a moves", 1.0, boolean=True),
    Port("on.b", "", "input", "discrete", "Whether b moves", 1.0, boolean=True),
    Port("x.a", "m", "output", "continuous", "Position of a"),
    Port("x.b", "rad", "output", "continuous", "Position of b"),
    Port("moving.a", "", "output", "discrete", "Whether a moved", boolean=True),
    Port("moving.b", "", "output", "discrete", "Whether b moved", boolean=True),
    Port("calls", "", "output", "discrete", "Number of steps"),
    Port("gain.a", "", "parameter", "tunable", "Gain of a", 2.0),
    Port("gain.b", "", "parameter", "tunable", "Gain of b", 3.0),
    Port("x_start.a", "m", "parameter", "fixed", "Start of a", 0.1),
    Port("x_start.b", "rad", "parameter", "fixed", "Start of b", 0.2),
)
INDEX = {port.name: k for k, port in enumerate(PORTS)}
ARRAYS = {"u": 0, "on": 2, "x": 4, "moving": 6, "calls": 8, "gain": 9, "x_start": 11, "time": 13}


class ArrayModel(FmuModel):
    """Model of x' = gain u^3 - sin x, integrated by Euler's method if `on` is set."""

    description = "Two of a kind"

    def __init__(self, values: FloatArray | None = None) -> None:
        super().__init__(PORTS, values)
        self._count = 0.0
        self._x = np.zeros(2)

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        return cls(values)

    def initialize(self, t: float = 0.0) -> None:
        self._x, self._count = np.sin(self.parameters[2:]), 0.0
        self._write(np.zeros(2))

    def step(self, t: float, h: float) -> None:
        u, on = self.inputs[:2], self.inputs[2:]
        self._x = self._x + h * on * (self.parameters[:2] * u**3 - np.sin(self._x))
        self._count += 1
        self._write(on)

    def get_state(self) -> bytes:
        return np.append(self._x, self._count).tobytes()

    def set_state(self, state: bytes) -> None:
        values = np.frombuffer(state)
        self._x, self._count = values[:2].copy(), float(values[2])

    def _write(self, moving: FloatArray) -> None:
        self.outputs[:] = *self._x, *moving, self._count
