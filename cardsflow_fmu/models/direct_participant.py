"""Models as participants of a co-simulation, without any FMI."""

from __future__ import annotations

from collections.abc import Mapping

from cardsflow_fmu.signals.units import KNOWN_UNITS, Unit

from .model import FmuModel


class DirectParticipant:
    """A model stepped as a plain Python object."""

    def __init__(self, name: str, model: FmuModel) -> None:
        self.name = name
        self.input_names = tuple(p.name for p in model.ports if p.causality == "input")
        self.output_names = tuple(p.name for p in model.ports if p.causality == "output")
        self.units: Mapping[str, Unit] = {
            p.name: KNOWN_UNITS[p.unit] for p in model.ports if p.unit
        }
        self.inputs = model.inputs
        self.outputs = model.outputs
        self.step = model.step
        self.close = model.close
        model.initialize()
