"""Writer of complete experiments: plain data, and the files that FMUs contain."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.json_text import json_text

from .config.custom_law import CustomLaw
from .experiment import EXPERIMENT_FILE, Experiment
from .motion.look_ahead import LOOK_AHEAD_FILE
from .packed_files import (
    Files,
    collision_meshes,
    require_packable,
    robot_files,
    robot_folder,
    world_meshes,
)
from .settings.hardware import hardware_data
from .settings.muscles import muscle_data
from .settings.robots import part_data, robot_data


def experiment_data(experiment: Experiment) -> dict[str, Any]:
    """Return an experiment as plain data, without robot files and external FMUs."""
    robot, start, disturbance = experiment.robot, experiment.start, experiment.disturbance
    names = [c.name for c in robot.coordinates]
    data: dict[str, Any] = {
        "muscles": {muscle.name: muscle_data(muscle) for muscle in robot.muscles},
        "start": {
            "q": dict(zip(names, start.q, strict=True)),
            "qd": dict(zip(names, start.qd, strict=True)),
        },
        "plant": experiment.plant.data(),
        "controller": experiment.controller.data(),
        "reference": experiment.reference.data(),
        "run": experiment.run.data(),
        "wiring": {
            model: {
                target.removeprefix(f"{model}."): source
                for target, source in experiment.wiring.items()
                if target.startswith(f"{model}.")
            }
            for model in ("plant", "controller")
        },
    }
    if experiment.parts:
        data["robots"] = [part_data(part) for part in experiment.parts]
    else:
        data["robot"] = robot_data(robot, experiment.robot_path, experiment.robot_overrides)
    if experiment.world is not None:
        data["world"] = experiment.world.data()
    if experiment.estimator is not None:
        data["estimator"] = experiment.estimator.data()
    if experiment.faults is not None:
        data["faults"] = experiment.faults.data()
    if about := experiment.about.model_dump(exclude_defaults=True):
        data["about"] = about
    if disturbance is not None:
        points = [f.name for f in robot.task_frames if not f.is_orientation]
        values = disturbance.data()
        data["disturbance"] = values | {"force": dict(zip(points, values["force"], strict=True))}
    return data


def experiment_resources(experiment: Experiment, *, with_hardware: bool = False) -> Files:
    """Return the files that an FMU contains: experiment, robots, and meshes.

    Args:
        with_hardware: Whether to include [hardware]. Only the hardware FMU needs it; the other FMUs
            are the same with any hardware.

    Returns:
        Content, or a file to copy, by path below the resources of the FMU.
    """
    data = experiment_data(experiment)
    files: Files = {}
    if experiment.parts:
        rows = []
        for part, row in zip(experiment.parts, data["robots"], strict=True):
            folder = f"robots/{part.name}"
            files |= _robot_files(folder, part.files, part.robot, experiment)
            rows.append({**row, "path": _main_file(folder, part.files)})
        data["robots"] = rows
    else:
        files |= _robot_files("robot", experiment.robot_files, experiment.robot, experiment)
        data["robot"] = {**data["robot"], "path": _main_file("robot", experiment.robot_files)}
    if experiment.scene is not None:
        data["world"], meshes = world_meshes(data["world"], experiment.scene.mesh_roots or ())
        files |= meshes
    if (law := experiment.controller.custom_law) is not None:
        carried = f"controller/{law.file.name}"
        files[carried] = require_packable(law.file, experiment.roots, "controller.type")
        data["controller"]["type"] = str(law._replace(file=Path(carried)))
    if (policy := experiment.controller.policy) is not None:
        carried = f"controller/{policy.name}"
        files[carried] = require_packable(policy, experiment.roots, "controller.policy")
        data["controller"]["policy"] = carried
    if experiment.feedback is not None and (gains := experiment.controller.gains) is not None:
        files["controller/gains.csv"] = gains
        data["controller"]["gains"] = "controller/gains.csv"
    if experiment.look_ahead is not None:
        files[LOOK_AHEAD_FILE] = json_text(experiment.look_ahead.data()).encode()
    files |= _custom_muscle_laws(data["muscles"], experiment)
    if with_hardware:
        data["hardware"] = hardware_data(experiment.hardware, experiment.robot)
    files[EXPERIMENT_FILE] = json_text(data, indent=1, sort_keys=True).encode()
    return files


def _custom_muscle_laws(muscles: dict[str, Any], experiment: Experiment) -> Files:
    """Return the files of custom muscle laws, and update their paths in the data."""
    files: Files = {}
    for name, row in muscles.items():
        law = CustomLaw.of(row.get("model", {}).get("kind", ""))
        if law is None:
            continue
        carried = f"muscles/{law.file.name}"
        if files.setdefault(carried, law.file) != law.file:
            problem = "has the same name as the file of another muscle law; rename one"
            raise InputError(problem, file=law.file, key=f"muscles.{name}.model")
        row["model"]["kind"] = str(law._replace(file=Path(carried)))
    return files


def _robot_files(place: str, paths: Sequence[Path], robot: Robot, experiment: Experiment) -> Files:
    """Return the files of a robot with its collision meshes."""
    files, scene = robot_files(place, paths, experiment.roots), experiment.scene
    if scene is not None and scene.links == "meshes":
        folder = robot_folder(place, paths)
        files |= collision_meshes(folder, robot, paths[0].parent, experiment.roots)
    return files


def _main_file(place: str, paths: Sequence[Path]) -> str:
    """Return the path of the main file of a robot in the resources."""
    return f"{robot_folder(place, paths)}/{paths[0].name}"
