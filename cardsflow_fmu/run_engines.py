"""What computes each participant of a run, and what steps them: for its summary."""

from __future__ import annotations

from .experiment import Experiment
from .foreign_fmu import HARDWARE

MASTERS = {
    "fmu": "Python, over FMUs",
    "direct": "Python, over objects",
    "native": "C",
}
"""What steps the participants, by how a run goes."""


def engines(experiment: Experiment, through: str) -> dict[str, str]:
    """What computes plant and controller.

    Args:
        experiment: What is run.
        through: What is stepped: `direct`, `fmu` or `native`.
    """
    if through == "native":
        return {"plant": "native", "controller": "native"}
    from sim_dart.engine import chosen_engine

    plant = chosen_engine(experiment.plant.engine, experiment.scene)
    controller = "dart" if experiment.controller.engine == "dart" else "core"
    found = {"plant": str(plant), "controller": controller}
    if experiment.hardware.use:
        found["plant"] = HARDWARE
    return found | {role: fmu.file.name for role, fmu in experiment.fmus.items() if role in found}
