"""An experiment as plain data, complete: what travels in its FMUs and reads back as the same."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot.model.trajectory import Trajectory

from .muscles import model_data
from .robots import parts_data

if TYPE_CHECKING:
    from sim_dart.scene import Scene

    from .experiment import (
        ControllerSettings,
        DisturbanceSettings,
        Experiment,
        FlowerSettings,
        ReferenceSettings,
        RunSettings,
        TaskSettings,
    )


def experiment_data(experiment: Experiment) -> dict[str, Any]:
    """Everything but the robot's files and the external FMUs.

    Args:
        experiment: What to write.
    """
    robot = experiment.robot
    names = [c.name for c in robot.coordinates]
    data = {
        **_robots(experiment),
        "muscles": {
            muscle.name: {"f_min": muscle.f_min}
            | ({"f_max": muscle.f_max} if math.isfinite(muscle.f_max) else {})
            | model_data(muscle.model)
            for muscle in robot.muscles
        },
        "start": {
            "q": dict(zip(names, experiment.start.q, strict=True)),
            "qd": dict(zip(names, experiment.start.qd, strict=True)),
        },
        "plant": {
            "step": experiment.plant.step,
            "mass_scale": list(experiment.plant.mass_scale),
            "integrator": experiment.plant.integrator,
            "substeps": experiment.plant.substeps,
            "engine": experiment.plant.engine,
            "energy": experiment.plant.energy,
            "wrenches": list(experiment.plant.wrenches),
        },
        "controller": _controller(experiment.controller),
        "reference": _reference(experiment.reference),
        "run": _run(experiment.run),
        "wiring": {
            model: {
                target.removeprefix(f"{model}."): source
                for target, source in experiment.wiring.items()
                if target.startswith(f"{model}.")
            }
            for model in ("plant", "controller")
        },
    }
    if experiment.disturbance is not None:
        frames = [f.name for f in robot.task_frames if not f.is_orientation]
        data["disturbance"] = _disturbance(experiment.disturbance, frames)
    return data


def _robots(experiment: Experiment) -> dict[str, Any]:
    """The robot or robots, and the world around them."""
    robot, scene = experiment.robot, experiment.scene
    world = {} if scene is None else {"world": _world(scene)}
    if experiment.parts:
        return {"robots": parts_data(experiment.parts)} | world
    data = {
        "path": str(experiment.robot_path),
        "cable_set": robot.cable_set,
        "gravity": list(robot.gravity),
    } | ({"operational_space": robot.task_set} if robot.task_set else {})
    return {"robot": data | dict(experiment.robot_changes)} | world


def _world(scene: Scene) -> dict[str, Any]:
    from .world import world_data  # it needs DART, which others can do without

    return world_data(scene)


def _run(run: RunSettings) -> dict[str, Any]:
    data = {"duration": run.duration, "step": run.step, "coupling": run.coupling.scheme}
    ordered = run.coupling.scheme == "gauss_seidel"
    return data | ({"order": list(run.coupling.order)} if ordered else {})


def _controller(controller: ControllerSettings) -> dict[str, Any]:
    data = {
        "type": controller.type,
        "kp": list(controller.kp),
        "kd": list(controller.kd),
        "period": controller.period,
        "solver": controller.solver,
        "weights": list(controller.weights),
        "ki": list(controller.ki),
        "observer": controller.observer,
        "delay": controller.delay,
        "predict": controller.predict,
        "muscle_horizon": controller.muscle_horizon,
        "engine": controller.engine,
    }
    return data if controller.tasks is None else data | _tasks(controller.tasks)


def _tasks(tasks: TaskSettings) -> dict[str, Any]:
    posture = tasks.posture
    return {
        "posture": False
        if posture is None
        else {"kp": list(posture.kp), "kd": list(posture.kd), "q0": list(posture.q0)},
        # no number stands for infinity in JSON
        "task_weights": [w if math.isfinite(w) else "exact" for w in tasks.task_weights],
        "priorities": list(tasks.priorities),
        "acceleration_weights": list(tasks.acceleration_weights),
        "force_rate_weights": list(tasks.force_rate_weights),
        "pretension": list(tasks.pretension),
        "limit_bandwidth": False if tasks.limit_bandwidth is None else tasks.limit_bandwidth,
    }


def _reference(reference: ReferenceSettings) -> dict[str, Any]:
    curve = reference.curve
    data = _trajectory(curve) if isinstance(curve, Trajectory) else _flower(curve)
    if reference.approach is not None:
        approach = reference.approach
        data["approach"] = {"duration": approach.duration, "start": list(approach.start)}
    return data


def _flower(flower: FlowerSettings) -> dict[str, Any]:
    return {
        "flower": {
            "centre": list(flower.centre),
            "axes": [list(axis) for axis in flower.axes],
            "radius": flower.radius,
            "petals": flower.petals,
            "duration": flower.duration,
        }
    }


def _trajectory(trajectory: Trajectory) -> dict[str, Any]:
    letter = "q" if trajectory.space == "joint" else "y"

    def values(ending: str, numbers: Sequence[float]) -> dict[str, list[float]]:
        return {letter + ending: list(numbers)} if numbers else {}

    return {
        "name": trajectory.name,
        "spline": trajectory.spline,
        "points": [
            {"time": point.time}
            | values("", point.q)
            | values("d", point.qd)
            | values("dd", point.qdd)
            | ({"blend_time": point.blend_time} if point.blend_time else {})
            for point in trajectory.points
        ],
    }


def _disturbance(disturbance: DisturbanceSettings, frames: Sequence[str]) -> dict[str, Any]:
    forces = zip(frames, disturbance.forces, strict=True)
    return {
        "force": {name: list(force) for name, force in forces},
        "begin": disturbance.begin,
        "known": disturbance.known,
    } | ({"end": disturbance.end} if math.isfinite(disturbance.end) else {})
