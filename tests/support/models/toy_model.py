"""Small model for tests of the FMU runtime: a driven oscillator that fails on request."""

from __future__ import annotations

import struct
import weakref
from pathlib import Path
from typing import ClassVar, Self

import numpy as np

from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.runtime.model import FloatArray, FmuModel

NEVER = 1e300

PORTS = (
    Port("u", "N", "input", "continuous", "Force"),
    Port("locked", "", "input", "discrete", "Hold still", boolean=True),
    Port("x", "m", "output", "continuous", "Position"),
    Port("v", "m/s", "output", "continuous", "Velocity"),
    Port("work", "N.m", "output", "continuous", "Work done by the force"),
    Port("is_right", "", "output", "discrete", "Whether x > 0", boolean=True),
    Port("stiffness", "1/s2", "parameter", "fixed", "Per mass", 40.0),
    Port("gain", "", "parameter", "tunable", "Of the force", 1.5),
    Port("fail_at", "s", "parameter", "tunable", "Raise at this time", NEVER),
    Port("interrupt", "", "parameter", "tunable", "Raise KeyboardInterrupt", boolean=True),
)
REFERENCES = {port.name: reference for reference, port in enumerate(PORTS)}


class ToyModel(FmuModel):
    """Oscillator with the outputs position and velocity; work and stiffness are internal."""

    description = "Driven oscillator"
    alive: ClassVar[weakref.WeakSet[ToyModel]] = weakref.WeakSet()

    def __init__(self, x_start: float, values: FloatArray | None = None) -> None:
        super().__init__(PORTS, values)
        self._x_start = x_start
        self._stiffness = float("nan")
        self._state = np.zeros(3)
        self.is_broken = False
        self.alive.add(self)

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        return cls(float((folder / "x_start.txt").read_text("utf-8")), values)

    def initialize(self, t: float = 0.0) -> None:
        self._stiffness = float(self.parameters[0])
        self._state[:] = self._x_start, 0.0, 0.0
        self._write_outputs()

    def step(self, t: float, h: float) -> None:
        assert type(t) is float
        assert type(h) is float
        self._fail_when_asked(t)
        force, locked = self.inputs
        x, v, work = self._state
        if not locked:
            v += h * (self.parameters[1] * force - self._stiffness * x)
            x += h * v
            work += h * v * force
        self._state[:] = x, v, work
        self._write_outputs()

    def get_state(self) -> bytes:
        return self._state.tobytes()

    def set_state(self, state: bytes) -> None:
        self._state[:] = struct.unpack("<3d", state)

    def reset(self) -> None:
        super().reset()
        assert not self.is_broken

    def _fail_when_asked(self, t: float) -> None:
        if t < self.parameters[2]:
            return
        self.is_broken = True
        self._state[:] = float("nan")
        if self.parameters[3]:
            raise KeyboardInterrupt
        raise ValueError(f"100 % broken at {t} s: größer als #1")

    def _write_outputs(self) -> None:
        self.outputs[:3] = self._state
        self.outputs[3] = self._state[0] > 0


class OtherToyModel(ToyModel):
    """Oscillator with the opposite start position."""

    def initialize(self, t: float = 0.0) -> None:
        super().initialize()
        self._state[0] *= -1
        self._write_outputs()
