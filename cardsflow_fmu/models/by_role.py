"""Model classes by name, and checks whether models can compute in C."""

from __future__ import annotations

from addin_sdfusion.robot import InputError
from cardsflow_fmu.cosim.signals.roles import ESTIMATOR, HARDWARE, SENSORS
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.runtime.model_file import NativeModel

from .c_model import CModel
from .controller import ControllerModel
from .estimator import EstimatorModel
from .experiment_model import ExperimentModel
from .plant import PlantModel
from .reference import ReferenceModel
from .sensors import SensorsModel

C_MODELS: dict[str, type[CModel]] = {
    "plant": PlantModel,
    "controller": ControllerModel,
    "reference": ReferenceModel,
    SENSORS: SensorsModel,
    ESTIMATOR: EstimatorModel,
}
"""Models that compute in C unless the experiment requires Python or DART."""


def model_class(name: str) -> type[ExperimentModel]:
    """Return the class of a model."""
    if name == HARDWARE:
        from .hardware import HardwareModel  # imports sessions and links

        return HardwareModel
    return C_MODELS[name]


def model_in_c(experiment: Experiment, model: str, native: bool | None) -> NativeModel | None:
    """Return the native model of an experiment, or None if a Python process hosts it.

    Args:
        native: Whether the model computes in C (default: if possible).

    Raises:
        InputError: `native` is true, but the model requires Python or DART or is invalid.
    """
    if native is False:
        return None
    unsupported = missing_in_c(experiment, model)
    if native and unsupported is not None:
        raise InputError(
            f"a native {model} does not support {unsupported}; build it without --compute c",
            file=experiment.file,
            key="controller" if model == "controller" else None,
        )
    if unsupported is not None:
        return None
    is_plant = model == "plant"
    return NativeModel(C_MODELS[model].file(experiment), is_plant, is_plant)


def missing_in_c(experiment: Experiment, model: str) -> str | None:
    """Return a requirement of a model that native models do not support.

    Returns:
        The requirement, such as `worlds with contacts`, or None if a native model is possible.
    """
    if model not in C_MODELS:
        return "links to hardware"
    return C_MODELS[model].missing(experiment)
