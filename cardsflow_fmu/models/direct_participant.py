"""Participants of a co-simulation that contain models directly, without FMI."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from addin_sdfusion.robot import SimulationError
from cardsflow_fmu.cosim.participant import CStep, Idle, WiredPorts
from cardsflow_fmu.cosim.signals.port import Port
from cardsflow_fmu.runtime.model import FmuModel


class DirectParticipant(WiredPorts):
    """Participant that steps a model directly."""

    def __init__(self, name: str, model: FmuModel) -> None:
        super().__init__(name, model.ports, model.inputs, model.outputs)
        self.step, self.close = model.step, model.close
        c_step: CStep | None = getattr(model, "c_step", None)

        def failure(code: int, t: float) -> SimulationError:
            assert c_step is not None
            return SimulationError(f"the {name} failed at t = {t:.6g} s: {c_step.failure(code, t)}")

        self.c_step = None if c_step is None else c_step._replace(failure=failure)
        model.initialize()


class IdleParticipant(Idle, WiredPorts):
    """Participant with the inputs and outputs of a model, without the model."""

    def __init__(self, name: str, ports: Sequence[Port]) -> None:
        sides = (sum(p.causality == side for p in ports) for side in ("input", "output"))
        super().__init__(name, ports, *map(np.zeros, sides))
