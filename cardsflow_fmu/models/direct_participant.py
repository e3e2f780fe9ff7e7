"""Models as participants of a co-simulation, without any FMI."""

from __future__ import annotations

from cardsflow_fmu.cosim.participant import WiredPorts

from .model import FmuModel


class DirectParticipant(WiredPorts):
    """A model stepped as a plain Python object."""

    def __init__(self, name: str, model: FmuModel) -> None:
        super().__init__(name, model.ports, model.inputs, model.outputs)
        self.step, self.close = model.step, model.close
        model.initialize()
