"""experiment.toml -> Experiment: what is simulated, how it is controlled, and for how long."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from addin_sdfusion.robot import Robot
from addin_sdfusion.robot.trajectory import Trajectory

_RESOURCE = "experiment.json"


@dataclass(frozen=True, slots=True)
class StartSettings:
    """The state at the start.

    Attributes:
        q: Joint positions, in [rad] or [m].
        qd: Joint velocities, in [rad/s] or [m/s].
    """

    q: tuple[float, ...]
    qd: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class PlantSettings:
    """The simulated robot.

    Attributes:
        step: Internal step, in [s].
    """

    step: float


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """The controller.

    Attributes:
        type: Kind of controller.
        kp: Position gain of every coordinate, in [1/s²].
        kd: Velocity gain of every coordinate, in [1/s].
        period: Time between two ticks, in [s].
        solver: Name of a qpsolvers back end.
        weights: Diagonal of H, one a muscle, in [1/N²].
    """

    type: str
    kp: tuple[float, ...]
    kd: tuple[float, ...]
    period: float
    solver: str
    weights: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class RunSettings:
    """The co-simulation.

    Attributes:
        duration: In [s].
        step: Communication step, in [s].
        output: Folder for the results.
    """

    duration: float
    step: float
    output: Path

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.duration / self.step)


@dataclass(frozen=True)
class Experiment:
    """An experiment, complete and checked.

    Attributes:
        file: Where it comes from.
        robot: The robot, with the cable set and the bounds that the experiment asks for.
        robot_path: The robot's main file.
        robot_files: Every file that makes up the robot.
        trajectory: The reference's points.
        start: The state at the start.
        plant: Settings of the plant.
        controller: Settings of the controller.
        run: Settings of the co-simulation.
        wiring: Inputs that are not connected to the output of the same name: `controller.q.elbow`
            -> `plant.q.elbow`.
    """

    file: Path
    robot: Robot
    robot_path: Path
    robot_files: tuple[Path, ...]
    trajectory: Trajectory
    start: StartSettings
    plant: PlantSettings
    controller: ControllerSettings
    run: RunSettings
    wiring: Mapping[str, str]

    @property
    def name(self) -> str:
        """Name of the folder that the experiment stands in."""
        return self.file.resolve().parent.name

    @staticmethod
    def load(path: str | Path, settings: Mapping[str, Any] | None = None) -> Experiment:
        """Read an experiment.

        Args:
            path: An experiment.toml, or the folder that holds one.
            settings: Changes by full key, such as `{"controller.period": 0.01}`.

        Raises:
            InputError: Something in it is wrong; the message names file and key.
        """
        from .experiment_reader import read_experiment

        return read_experiment(Path(path), settings or {})

    @staticmethod
    def from_resources(folder: Path) -> Experiment:
        """Read the experiment that travels in an FMU.

        Args:
            folder: The FMU's resources.

        Raises:
            InputError: Something in it is wrong.
        """
        return Experiment.load(folder / _RESOURCE)

    def resources(self) -> dict[str, bytes | Path]:
        """The files that an FMU carries: the experiment, complete, and the robot's files.

        Returns:
            Content, or a file to copy, by its path below the FMU's resources.
        """
        root = self.robot_path.parent
        files: dict[str, bytes | Path] = {
            f"robot/{file.relative_to(root).as_posix()}": file for file in self.robot_files
        }
        data = self.data | {
            "robot": {**self.data["robot"], "path": f"robot/{self.robot_path.name}"}
        }
        files[_RESOURCE] = json.dumps(data, indent=1, sort_keys=True).encode()
        return files

    @cached_property
    def data(self) -> dict[str, Any]:
        """Everything but the robot's files as plain data, which reads back as this experiment."""
        robot, controller, trajectory = self.robot, self.controller, self.trajectory
        names = [c.name for c in robot.coordinates]
        return {
            "robot": {
                "path": str(self.robot_path),
                "cable_set": robot.cable_set,
                "operational_space": robot.task_set,
                "gravity": list(robot.gravity),
            },
            "muscles": {
                muscle.name: {"f_min": muscle.f_min}
                | ({"f_max": muscle.f_max} if math.isfinite(muscle.f_max) else {})
                for muscle in robot.muscles
            },
            "start": {
                "q": dict(zip(names, self.start.q, strict=True)),
                "qd": dict(zip(names, self.start.qd, strict=True)),
            },
            "plant": {"step": self.plant.step},
            "controller": {
                "type": controller.type,
                "kp": list(controller.kp),
                "kd": list(controller.kd),
                "period": controller.period,
                "solver": controller.solver,
                "weights": list(controller.weights),
            },
            "reference": {
                "name": trajectory.name,
                "spline": trajectory.spline,
                "points": [
                    {"time": point.time, "q": list(point.q)}
                    | ({"qd": list(point.qd)} if point.qd else {})
                    | ({"qdd": list(point.qdd)} if point.qdd else {})
                    | ({"blend_time": point.blend_time} if point.blend_time else {})
                    for point in trajectory.points
                ],
            },
            "run": {"duration": self.run.duration, "step": self.run.step},
            "wiring": {
                model: {
                    target.removeprefix(f"{model}."): source
                    for target, source in self.wiring.items()
                    if target.startswith(f"{model}.")
                }
                for model in ("plant", "controller")
            },
        }
