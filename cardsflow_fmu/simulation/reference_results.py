"""Reference results of a model, with which other tools compare their simulation of its FMU."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from addin_sdfusion.robot import CardsflowError
from cardsflow_fmu.cosim.signals.ports import SOLVE_TIME
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.fmu.related_files import ReferenceResults
from cardsflow_fmu.models.by_role import model_class
from cardsflow_fmu.models.plant import PlantModel

_STEPS = 100
_FINE = 10  # integrator steps per step, for model exchange


def reference_results(
    experiment: Experiment, name: str, step: float, *, is_continuous: bool = False
) -> ReferenceResults:
    """Return the outputs of a model over 100 steps.

    Args:
        name: Name of the model; not the hardware.
        step: Communication step, in [s].
        is_continuous: Whether the results are those of a plant for model exchange. They are
            computed by the integrator rk4 with ten steps per communication step.
    """
    if is_continuous:
        fine = experiment.plant.copy_with(integrator="rk4", step=step, substeps=_FINE)
        experiment = replace(experiment, plant=fine)
    model = (PlantModel if is_continuous else model_class(name))(experiment)
    columns = [k for k, port in enumerate(model.ports) if _is_shown(port.name, port.causality)]
    rows, failure = [], ""

    def steps() -> Iterator[None]:
        model.initialize(0.0)
        yield
        for k in range(_STEPS):
            model.step(k * step, step)
            yield

    try:
        for k, _ in enumerate(steps()):
            rows.append([k * step, *model.values[columns]])
    except CardsflowError as error:
        failure = str(error)
    names = ["time", *(model.ports[k].name for k in columns)]
    return ReferenceResults(names, np.reshape(rows, (-1, len(names))), step, failure)


def _is_shown(name: str, causality: str) -> bool:
    return causality == "output" and name != SOLVE_TIME
