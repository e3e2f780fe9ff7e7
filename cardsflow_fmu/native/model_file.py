"""Native model files, from which FMUs compute in C alone, without any Python; see native_file.h.

The settings stand in the order that the C sources of the models say.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.controller import ControllerSettings
from cardsflow_fmu.models.muscle_control import late_periods
from cardsflow_fmu.models.start_commands import start
from cardsflow_fmu.signals.muscles import (
    driven_muscles,
    ideal_muscles,
    modelled_muscles,
    state_order,
)
from sim_dart import compile_blob
from sim_dart.core.blob import fixed_energy
from sim_dart.core.tasks import point_rows, task_rows
from sim_dart.core.wrench_points import wrench_points
from sim_dart.plant.settings import core_lacks

from .reference import reference_settings

NATIVE_FILE = "native.bin"
NATIVE_MODELS = ("plant", "controller", "reference")

_MAGIC = b"CARDSNAT"
_VERSION = 1
_HEADER_SIZE = 32
_RULES = ("euler", "rk4")
_LAWS = ("joint_space", "operational_space")


class NativeModel(NamedTuple):
    """What a native FMU is made of.

    Attributes:
        contents: Of `resources/native.bin`.
        has_derivatives: Whether it has directional derivatives.
    """

    contents: bytes
    has_derivatives: bool = False


def native_model(experiment: Experiment, model: str) -> NativeModel:
    """The native model of an experiment.

    Raises:
        InputError: The experiment has something that the C core cannot do.
    """
    return NativeModel(_native_file(experiment, model), has_derivatives=model == "plant")


def _native_file(experiment: Experiment, model: str) -> bytes:
    """The contents of `resources/native.bin`."""
    if model == "reference":
        return _encode(model, b"", reference_settings(experiment))
    if model == "plant":
        _require_native_plant(experiment)
        robot = experiment.plant_robot
        plant = experiment.plant
        rule = plant.integrator, plant.energy, plant.wrenches
        own = _plant_settings(robot, plant.substeps, *rule)
    else:
        robot, controller = experiment.robot, experiment.controller
        _require_native_law(experiment)
        own = [*_muscle_settings(experiment), *_controller_settings(robot, controller)]
    return _encode(model, compile_blob(robot), [*_robot_settings(robot), *own])


def _require_native_plant(experiment: Experiment) -> None:
    """Refuse what plants in C lack."""
    lacking = core_lacks(experiment.scene)
    if lacking is not None:
        raise InputError(
            f"a native plant does not have {lacking}; build it without --native",
            file=experiment.file,
        )


def _require_native_law(experiment: Experiment) -> None:
    """Refuse what the laws in C lack."""
    controller, lacking = experiment.controller, None
    if controller.type not in _LAWS:
        lacking = f"the law {controller.type!r} (only {' and '.join(_LAWS)})"
    elif controller.tasks is not None and len(set(controller.tasks.priorities)) > 1:
        lacking = "tasks of several priorities"
    if lacking:
        raise InputError(
            f"a native controller does not have {lacking}; build the FMU without --native",
            file=experiment.file,
            key="controller",
        )


def _encode(model: str, blob: bytes, settings: Sequence[ArrayLike]) -> bytes:
    numbers = np.concatenate([np.ravel(np.asarray(s, dtype=np.float64)) for s in settings])
    body = struct.pack("<III", NATIVE_MODELS.index(model), len(blob), numbers.size)
    body += blob + bytes(-len(blob) % 8) + numbers.astype("<f8").tobytes()
    size = _HEADER_SIZE - struct.calcsize("<III") + len(body)
    return _MAGIC + struct.pack("<III", _VERSION, size, zlib.crc32(body)) + body


def _indices(indices: Sequence[int]) -> list[ArrayLike]:
    """How many, and which."""
    return [len(indices), indices]


def _robot_settings(robot: Robot) -> list[ArrayLike]:
    points = [row // 3 for row in point_rows(robot)[::3]]
    return [*_indices(points), *_indices(task_rows(robot))]


def _plant_settings(
    robot: Robot,
    substeps: int,
    integrator: str = "euler",
    energy: bool = False,
    wrenches: Sequence[str] = (),
) -> list[ArrayLike]:
    commanded = [*ideal_muscles(robot), *driven_muscles(robot)]
    indices = (commanded, modelled_muscles(robot), state_order(robot))
    muscles = [number for some in indices for number in _indices(some)]
    frames, points = wrench_points(robot, wrenches)
    options = _RULES.index(integrator), energy, fixed_energy(robot)
    return [substeps, *muscles, options, len(frames), frames, points]


def _muscle_settings(experiment: Experiment) -> list[ArrayLike]:
    """What the controller knows of muscles with laws."""
    robot = experiment.robot
    indices = [*_indices(state_order(robot)), *_indices(driven_muscles(robot))]
    if not modelled_muscles(robot):
        return [*indices, 0.0]
    begin = start(robot, experiment.start.q)
    ahead = experiment.controller.muscle_horizon, late_periods(robot)
    return [*indices, 1.0, ahead, begin.forces, begin.commands]


def _controller_settings(robot: Robot, controller: ControllerSettings) -> list[ArrayLike]:
    own: list[ArrayLike] = [
        controller.tasks is not None,
        controller.ki,
        controller.observer,
        controller.delay,
        controller.predict,
        controller.weights,
    ]
    return own if controller.tasks is None else [*own, *_task_settings(robot, controller.tasks)]


def _task_settings(robot: Robot, tasks: ControllerSettings) -> list[ArrayLike]:
    n = len(robot.coordinates)
    posture, rest = tasks.posture, np.zeros(n)
    return [
        [frame.is_orientation for frame in robot.task_frames for _ in frame.axes],
        tasks.acceleration_weights,
        tasks.force_rate_weights,
        tasks.pretension,
        tasks.task_weights,
        rest if posture is None else posture.kp,
        rest if posture is None else posture.kd,
        rest if posture is None else posture.q0,
        tasks.limit_bandwidth or 0.0,
    ]
