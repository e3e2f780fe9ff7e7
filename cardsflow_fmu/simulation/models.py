"""Models of an experiment by the names of their FMUs."""

from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.experiment_model import ExperimentModel
from cardsflow_fmu.models.hardware import HardwareModel
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.models.reference import ReferenceModel
from cardsflow_fmu.signals.roles import HARDWARE

MODELS: dict[str, type[ExperimentModel]] = {
    "plant": PlantModel,
    "controller": ControllerModel,
    "reference": ReferenceModel,
    HARDWARE: HardwareModel,
}


def model_name(role: str, experiment: Experiment) -> str:
    """Name of the model in a role: the hardware's in that of the plant, where it is used."""
    return HARDWARE if role == "plant" and experiment.hardware.use else role
