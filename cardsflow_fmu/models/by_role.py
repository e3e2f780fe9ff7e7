"""The models of an experiment by their names, and those of them that compute in C alone."""

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
"""Models that compute in C wherever the experiment needs no Python and no DART."""


def model_class(name: str) -> type[ExperimentModel]:
    """The class of a model."""
    if name == HARDWARE:
        from .hardware import HardwareModel  # with sessions and links

        return HardwareModel
    return C_MODELS[name]


def model_in_c(experiment: Experiment, model: str, native: bool | None) -> NativeModel | None:
    """The native model of an experiment; None where a Python process hosts it.

    Args:
        experiment: The experiment.
        model: Name of the model.
        native: Whether it computes in C: when None, if it can.

    Raises:
        InputError: It is to compute in C and needs Python or DART, or it is wrong.
    """
    if native is False or (native is None and missing_in_c(experiment, model) is not None):
        return None
    if native:
        require_in_c(experiment, model, "build it without --compute c")
    return NativeModel(C_MODELS[model].file(experiment), has_derivatives=model == "plant")


def require_in_c(experiment: Experiment, model: str, instead: str) -> None:
    """Refuse a model that needs Python or DART.

    Args:
        experiment: The experiment.
        model: Name of the model.
        instead: What to do then.

    Raises:
        InputError: It does; the message names what it needs.
    """
    lacking = missing_in_c(experiment, model)
    if lacking is not None:
        raise InputError(
            f"a native {model} does not have {lacking}; {instead}",
            file=experiment.file,
            key="controller" if model == "controller" else None,
        )


def missing_in_c(experiment: Experiment, model: str) -> str | None:
    """What a model of the experiment needs and native ones do not have, in words.

    Args:
        experiment: The experiment.
        model: Name of the model.

    Returns:
        Such as `worlds with contacts`; None where a native model has all.
    """
    if model not in C_MODELS:
        return "links to hardware"
    return C_MODELS[model].missing(experiment)
