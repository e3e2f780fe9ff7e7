"""Drive modes of a simulation in a browser: the experiment of each mode."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal, get_args

from addin_sdfusion.robot import InputError
from addin_sdfusion.robot.model.trajectory import Space
from cardsflow_fmu.cosim.coupling import Coupling
from cardsflow_fmu.cosim.participant import WiredPorts
from cardsflow_fmu.cosim.signals.ports import load_signals
from cardsflow_fmu.cosim.signals.world import wrench_signals
from cardsflow_fmu.cosim.wiring import members, routes
from cardsflow_fmu.experiment.config.table import Context
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.experiment.settings.controller import ControllerSettings, read_controller
from cardsflow_fmu.experiment.settings.robots import robot_names
from cardsflow_fmu.models.controller import ControllerModel
from sim_dart.core.frames import moving_frames

Mode = Literal["reference", "joints", "task", "muscles", "pose"]
"""What moves the robot: the reference of the experiment, targets of joints or of the task, commands
of muscles and motors, or joint positions without dynamics."""

MODES: tuple[Mode, ...] = get_args(Mode)

_SPACES: Mapping[Mode, Space] = {"joints": "joint", "task": "operational"}
_GAINS = {"kp": 100.0, "kd": 20.0}  # critically damped, at 10 rad/s
_INHERITED = ("period", "pretension", "passive", "dependent", "delay", "predict", "muscle_horizon")


def with_wrenches(experiment: Experiment) -> Experiment:
    """Return the experiment with external wrenches on every moving frame, to pull links.

    A frame stays without a wrench if all of its links have the name of an end-effector point.
    """
    robot, wrenches = experiment.robot, experiment.plant.wrenches
    _, places = moving_frames(robot)
    pulled = {places[name].frame for name in wrenches} | {-1}
    load_names = set(load_signals(robot))
    added = []
    for link in robot.links:
        frame = places[link.name].frame
        if frame not in pulled and not load_names.intersection(wrench_signals([link.name])):
            pulled.add(frame)
            added.append(link.name)
    wiring = dict.fromkeys((f"plant.{name}" for name in wrench_signals(added)), 0.0)
    return replace(
        experiment,
        plant=experiment.plant.copy_with(wrenches=(*wrenches, *added)),
        wiring={**wiring, **experiment.wiring},
    )


def experiment_in_mode(experiment: Experiment, mode: Mode) -> Experiment:
    """Return the experiment with the controller of a mode.

    Args:
        mode: The mode. `joints` and `task` use the controller of the experiment if it controls
            this space, otherwise a computed-torque law with a bandwidth of 10 rad/s.

    Raises:
        InputError: The experiment cannot be controlled in this mode.
    """
    if experiment.faults is not None and mode != "reference":  # there is no reference to slow down
        experiment = replace(experiment, faults=experiment.faults.copy_with(react=False))
    space = _SPACES.get(mode, experiment.controller.space)
    if mode == "task" and not experiment.robot.task_frames:
        raise InputError("the robot has no end-effector points")
    if space == experiment.controller.space:
        return experiment
    return replace(experiment, controller=_controller(experiment, space))


def _controller(experiment: Experiment, space: Space) -> ControllerSettings:
    controller = experiment.controller
    data: dict[str, Any] = {key: getattr(controller, key) for key in _INHERITED}
    context = Context(experiment.file, robot_names(experiment.robot, space))
    inherited = {key: list(v) if isinstance(v, tuple) else v for key, v in data.items()}
    return read_controller(_GAINS | inherited, context, experiment.run, space, experiment.start)


def models_in_mode(experiment: Experiment, mode: Mode) -> tuple[str, ...]:
    """Return the names of the models that step in a mode, in the order of the columns."""
    if mode == "reference":
        return experiment.columns
    if mode in ("muscles", "pose"):
        return ("plant",)
    return tuple(name for name in experiment.columns if name != "reference")


def stepping_in_mode(experiment: Experiment, names: tuple[str, ...]) -> Coupling:
    """Return the coupling of some models of an experiment."""
    coupling = experiment.stepping
    return replace(coupling, order=tuple(name for name in coupling.order if name in names))


def wiring_in_mode(
    experiment: Experiment, models: Sequence[WiredPorts], names: Collection[str]
) -> dict[str, str | float]:
    """Return the source of each input of the models that step in a mode.

    Args:
        models: All models of the experiment, with the start values of their inputs.
        names: The models that step. Inputs keep their value if their source does not step, and the
            page sets the targets of a controller without a reference.
    """
    starts = {
        f"{model.name}.{name}": float(value)
        for model in models
        for name, value in zip(model.input_names, model.inputs, strict=True)
    }
    if len(models) == 1:
        return dict(starts)  # of the plant alone
    wiring = {k: v for k, v in experiment.wiring.items() if members(k, starts)}
    if "controller" in names and "reference" not in names:
        group = ControllerModel.groups(experiment)["reference"]
        wiring |= {name: starts[name] for name in (f"controller.{port.name}" for port in group)}
    return {
        target: source if not isinstance(source, str) or _part(source) in names else starts[target]
        for target, source in routes(models, wiring).items()
        if _part(target) in names
    }


def _part(name: str) -> str:
    return name.split(".", 1)[0]
