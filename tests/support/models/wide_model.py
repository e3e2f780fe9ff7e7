"""Model that copies four or sixty inputs to outputs."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from cardsflow_fmu.cosim.signals.ports import Port
from cardsflow_fmu.runtime.model import FloatArray, FmuModel

FEW, MANY = 4, 60


def _ports(causality: str, few: str, many: str) -> list[Port]:
    names = [f"{few}.n{k}" for k in range(FEW)] + [f"{many}.n{k}" for k in range(MANY)]
    return [Port(name, "", causality, "continuous", "Value") for name in names]  # type: ignore[arg-type]


PORTS = (*_ports("input", "few", "many"), *_ports("output", "few_out", "many_out"))


class WideModel(FmuModel):
    """Model that copies inputs to outputs."""

    def __init__(self, values: FloatArray | None = None) -> None:
        super().__init__(PORTS, values)

    @classmethod
    def from_resources(cls, folder: Path, values: FloatArray | None = None) -> Self:
        return cls(values)

    def initialize(self, t: float = 0.0) -> None:
        self.outputs[:] = self.inputs

    def step(self, t: float, h: float) -> None:
        self.outputs[:] = self.inputs

    def get_state(self) -> bytes:
        return b""

    def set_state(self, state: bytes) -> None:
        assert not state
