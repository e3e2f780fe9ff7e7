"""Script from which pythonfmu packs a model of this package as an FMU."""

SCRIPT = """
from functools import partial

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

from cardsflow_fmu import Experiment
from cardsflow_fmu.models.{module} import {model} as Model

EXPERIMENT = {experiment!r}


class {name}(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.model = Model(Experiment.load(EXPERIMENT))
        self.model.initialize()
        for index, port in enumerate(self.model.ports):
            kind = Boolean if port.boolean else Real
            variability = {{"variability": getattr(Fmi2Variability, port.variability)}}
            self.register_variable(
                kind(
                    port.name,
                    causality=getattr(Fmi2Causality, port.causality),
                    getter=partial(self.get, index, bool if port.boolean else float),
                    setter=partial(self.put, index),
                    **variability,
                )
            )

    def get(self, index, kind):
        return kind(self.model.values[index])

    def put(self, index, value):
        self.model.values[index] = value

    def do_step(self, time, step):
        self.model.step(time, step)
        return True
"""
