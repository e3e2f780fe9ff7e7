"""Native model files, from which FMUs compute in C alone, without any Python."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.controller import ControllerSettings
from cardsflow_fmu.models.controller import ControllerModel
from cardsflow_fmu.models.estimator import EstimatorModel
from cardsflow_fmu.models.experiment_model import ExperimentModel
from cardsflow_fmu.models.muscle_control import late_periods
from cardsflow_fmu.models.plant import PlantModel
from cardsflow_fmu.models.reference import ReferenceModel
from cardsflow_fmu.models.sensors import SensorsModel
from cardsflow_fmu.models.start_commands import start
from cardsflow_fmu.signals.muscles import (
    commanded_muscles,
    driven_muscles,
    modelled_muscles,
    rubbing_muscles,
    state_order,
)
from controllers.qp.solver import DEFAULT_SOLVER
from sim_dart import compile_blob
from sim_dart.core.blob import fixed_energy
from sim_dart.core.tasks import point_rows, task_rows
from sim_dart.core.wrench_points import wrench_points
from sim_dart.plant.settings import core_lacks, python_laws

from .estimation import estimator_file, sensors_file
from .fields import NATIVE_MODELS, Counts, Fields, encode
from .reference import reference_fields

NATIVE_FILE = "native.bin"
MODELS: dict[str, type[ExperimentModel]] = {
    "plant": PlantModel,
    "reference": ReferenceModel,
    "sensors": SensorsModel,
    "estimator": EstimatorModel,
    "controller": ControllerModel,
}

_RULES = ("euler", "rk4")
_LAWS = ("joint_space", "operational_space")


class NativeModel(NamedTuple):
    """The file of a native FMU's model.

    Attributes:
        contents: Of `resources/native.bin`.
        has_derivatives: Whether it has directional derivatives.
    """

    contents: bytes
    has_derivatives: bool = False


def native_model(
    experiment: Experiment, model: str, instead: str = "build it without --native"
) -> NativeModel:
    """The native model of an experiment.

    Args:
        experiment: The experiment.
        model: Name of the model.
        instead: What to do where it has something that the C core cannot do.

    Raises:
        InputError: It has, or it is wrong.
    """
    lacking = missing_in_c(experiment, model)
    if lacking is not None:
        raise InputError(
            f"a native {model} does not have {lacking}; {instead}",
            file=experiment.file,
            key="controller" if model == "controller" else None,
        )
    return NativeModel(_native_file(experiment, model), has_derivatives=model == "plant")


def missing_in_c(experiment: Experiment, model: str) -> str | None:
    """What a model of the experiment needs and native ones do not have, in words.

    Args:
        experiment: The experiment.
        model: Name of the model.

    Returns:
        Such as `worlds with contacts`; None where a native model has all.
    """
    if model not in NATIVE_MODELS:
        return "links to hardware"
    if model in ("reference", "sensors", "estimator"):
        return None
    if (experiment.plant if model == "plant" else experiment.controller).engine == "dart":
        return 'the engine "dart"'
    if model == "plant":
        return core_lacks(experiment.scene, experiment.plant_robot)
    controller = experiment.controller
    if (laws := python_laws(experiment.robot)) is not None:
        return laws
    if controller.type not in _LAWS:
        return f"the law {controller.type!r} (only {' and '.join(_LAWS)})"
    if controller.tasks is not None and len(set(controller.tasks.priorities)) > 1:
        return "tasks of several priorities"
    if controller.solver != DEFAULT_SOLVER:
        return f"the QP solver {controller.solver!r}"
    if controller.norm == 1.0 or math.isinf(controller.norm):
        return f"the norm {controller.norm:g} of forces"
    return None


def _native_file(experiment: Experiment, model: str) -> bytes:
    """The contents of `resources/native.bin`."""
    groups = MODELS[model].groups(experiment)
    if model == "reference":
        return encode(model, b"", groups, *reference_fields(experiment))
    if model == "sensors":
        return sensors_file(experiment, groups)
    if model == "estimator":
        return estimator_file(experiment, groups)
    if model == "plant":
        robot = experiment.plant_robot
        plant = experiment.plant
        settings = plant_fields(robot, plant.substeps, plant.integrator, plant.wrenches)
        return encode(model, compile_blob(robot), groups, *settings)
    fields = _controller_fields(experiment)
    return encode(model, compile_blob(experiment.robot), groups, *fields)


def plant_fields(
    robot: Robot, substeps: int, integrator: str = "euler", wrenches: Sequence[str] = ()
) -> tuple[Counts, Fields]:
    """Counts and fields of a plant; see `encode`.

    Args:
        robot: The robot.
        substeps: Steps of the integrator in one of the plant.
        integrator: Its rule.
        wrenches: Names of links that take external wrenches.
    """
    frames, points = wrench_points(robot, wrenches)
    fields: Fields = {
        "load_rows": point_rows(robot),
        "task_rows": task_rows(robot),
        "commanded": commanded_muscles(robot),
        "motors": motors(robot),
        "modelled": modelled_muscles(robot),
        "rubbing": rubbing_muscles(robot),
        "state_order": state_order(robot),
        "external_frame": frames,
        "external_point": points,
        "substeps": substeps,
        "integrator": _RULES.index(integrator),
        "fixed_energy": fixed_energy(robot),
    }
    return {"external_points": len(frames)}, fields


def _controller_fields(experiment: Experiment) -> tuple[Counts, Fields]:
    robot, controller = experiment.robot, experiment.controller
    muscles = len(robot.muscles) if modelled_muscles(robot) else 0
    begin = start(robot, experiment.start.q) if muscles else None
    fields: Fields = {
        "load_rows": point_rows(robot),
        "motors": motors(robot),
        "state_order": state_order(robot),
        "commanded": driven_muscles(robot),
        "muscle_horizon": controller.muscle_horizon,
        "late_periods": late_periods(robot) if muscles else 0.0,
        "start_forces": [] if begin is None else begin.forces,
        "start_commands": [] if begin is None else begin.commands,
        "observer": controller.observer,
        "ramp_down": experiment.feeding.ramp_down if experiment.feeding else 0.0,
        "ramp_in": experiment.feeding.ramp_in if experiment.feeding else 0.0,
        "q_start": experiment.start.q,
        "ki": controller.ki,
        "delay": controller.delay,
        "predict": controller.predict,
        "H_f": controller.actuator_weights,
        "f_p": controller.pretensions,
        "norm": controller.norm,
        "passive": np.logical_or(controller.passive, controller.dependent),
        "dependent": controller.dependent,
    }
    rows = [] if controller.tasks is None else task_rows(robot)
    counts = {"tasks": len(rows), "modelled": muscles, "motors": len(robot.motors)}
    return counts, fields | {"task_rows": rows} | _task_fields(robot, controller)


def motors(robot: Robot) -> list[int]:
    """The coordinate of each motor."""
    return [j for j, coordinate in enumerate(robot.coordinates) if coordinate.actuated]


def _task_fields(robot: Robot, controller: ControllerSettings) -> Fields:
    """What the law in operational space knows; nothing of it for that in joint space."""
    tasks = controller.tasks
    rest, none = np.zeros(len(robot.coordinates)), (0.0,) * len(robot.muscles)
    posture = None if tasks is None else tasks.posture
    is_angle = [frame.is_orientation for frame in robot.task_frames for _ in frame.axes]
    return {
        "is_angle": [] if tasks is None else is_angle,
        "H_q": rest if tasks is None else tasks.acceleration_weights,
        "H_r": controller.with_motors(none if tasks is None else tasks.force_rate_weights),
        "W": [] if tasks is None else tasks.task_weights,
        "posture_kp": rest if posture is None else posture.kp,
        "posture_kd": rest if posture is None else posture.kd,
        "q0": rest if posture is None else posture.q0,
        "limit_bandwidth": 0.0 if tasks is None else tasks.limit_bandwidth or 0.0,
    }
