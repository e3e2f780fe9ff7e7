"""The files that an experiment takes along in its FMUs: itself, its robots, and their meshes."""

from __future__ import annotations

import json
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.mesh_files import MODEL_URI, mesh_file

from .hardware import hardware_data

if TYPE_CHECKING:
    from .experiment import Experiment

Files = dict[str, bytes | Path]

EXPERIMENT_FILE = "experiment.json"


def experiment_resources(experiment: Experiment, *, with_hardware: bool = False) -> Files:
    """Content, or a file to copy, by its path below an FMU's resources.

    Args:
        experiment: The experiment.
        with_hardware: Whether to tell of the hardware.

    Raises:
        InputError: A mesh stands where it cannot be taken along from.
    """
    data = dict(experiment.data)
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
    files[EXPERIMENT_FILE] = json.dumps(data, indent=1, sort_keys=True).encode()
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
            f"collision mesh {uri!r} of link {link!r} stands outside the robot's folder, and "
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
