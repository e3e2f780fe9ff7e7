"""An experiment as plain data, complete, and the files that FMUs carry of it."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.json_text import json_text
from addin_sdfusion.robot.mesh_files import MODEL_URI, mesh_file

from .experiment import EXPERIMENT_FILE, Experiment
from .settings.hardware import hardware_data
from .settings.muscles import muscle_data
from .settings.robots import part_data, robot_data

Files = dict[str, bytes | Path]


def experiment_data(experiment: Experiment) -> dict[str, Any]:
    """Everything but the robot's files and external FMUs; it reads back as the same."""
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
    if disturbance is not None:
        points = [f.name for f in robot.task_frames if not f.is_orientation]
        own = disturbance.data()
        data["disturbance"] = own | {"force": dict(zip(points, own["force"], strict=True))}
    return data


def experiment_resources(experiment: Experiment, *, with_hardware: bool = False) -> Files:
    """The files that an FMU carries: the experiment, complete, its robots, and their meshes.

    Args:
        experiment: The experiment.
        with_hardware: Whether the hardware is in it, which is nothing to the other FMUs: they are
            the same files whatever is driven.

    Returns:
        Content, or a file to copy, by its path below the FMU's resources.

    Raises:
        InputError: A mesh is where an FMU cannot carry it from.
    """
    data = experiment_data(experiment)
    files: Files = {}
    if experiment.parts:
        rows = []
        for part, row in zip(experiment.parts, data["robots"], strict=True):
            own = f"robots/{part.name}"
            files |= _robot_files(own, part.files, part.robot, experiment)
            rows.append({**row, "path": f"{own}/{part.files[0].name}"})
        data["robots"] = rows
    else:
        files |= _robot_files("robot", experiment.robot_files, experiment.robot, experiment)
        data["robot"] = {**data["robot"], "path": f"robot/{experiment.robot_path.name}"}
    if experiment.scene is not None:
        data["world"] = _with_meshes(data["world"], files)
    if with_hardware:
        data["hardware"] = hardware_data(experiment.hardware, experiment.robot)
    files[EXPERIMENT_FILE] = json_text(data, indent=1, sort_keys=True).encode()
    return files


def _robot_files(folder: str, own: tuple[Path, ...], robot: Robot, experiment: Experiment) -> Files:
    root = own[0].parent
    files: Files = {f"{folder}/{file.relative_to(root).as_posix()}": file for file in own}
    scene = experiment.scene
    if scene is not None and scene.links == "meshes":
        for link in robot.links:
            for mesh in link.meshes:
                if mesh.role == "collision":
                    inner = _inner_path(mesh.uri, link.name)
                    files[f"{folder}/{inner}"] = mesh_file(mesh.uri, root)
    return files


def _inner_path(uri: str, link: str) -> PurePosixPath:
    """Where a mesh is below the robot's folder."""
    text = uri.removeprefix("file://")
    if uri.startswith(MODEL_URI):
        _, _, text = uri.removeprefix(MODEL_URI).partition("/")
    path = PurePosixPath(text)
    if path.is_absolute() or ".." in path.parts or "\\" in text:
        raise InputError(
            f"collision mesh {uri!r} of link {link!r} is outside the robot's folder, and "
            "cannot travel in an FMU; put it into the folder, or run with --direct"
        )
    return path


def _with_meshes(world: dict[str, Any], files: Files) -> dict[str, Any]:
    """The table [world] with the meshes of objects and links beside it."""
    rows: dict[str, list[dict[str, Any]]] = {}
    for key in ("objects", "shapes"):
        rows[key] = []
        for k, row in enumerate(world[key]):
            if "file" not in row:
                rows[key].append(row)
                continue
            source = Path(row["file"])
            target = f"world/{key}_{k}{source.suffix}"
            files[target] = source
            rows[key].append({**row, "file": target})
    return world | rows
