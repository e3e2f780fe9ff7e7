"""The topics of a run for those who look at it: description, frames, cables and bodies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Finding, Robot
from addin_sdfusion.robot.formats.urdf.capabilities import URDF_ALONE
from addin_sdfusion.robot.formats.urdf.write import urdf_text
from addin_sdfusion.robot.formats.writing.carried_meshes import CarriedMeshes
from addin_sdfusion.robot.mesh_files import mesh_bytes
from cardsflow_fmu.cosim.signals.ports import coordinate_signals, identifier
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses, moved_point
from cardsflow_fmu.results.viewer.scene.meshes import link_meshes
from cardsflow_fmu.results.viewer.scene.motion import Motion, frame_rows, motion_of, task_points
from cardsflow_fmu.results.viewer.scene.muscle_paths import muscle_paths
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.ros_interface import message_types as types
from cardsflow_fmu.ros_interface.node import Topic
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.scene import Scene

from .markers import body_markers, cable_markers, task_markers
from .robot_frames import frame_transforms, transform_values
from .topics import Batch, nanoseconds

Rows = NDArray[np.int64]

RATE = 50.0
"""Frames a second."""

DESCRIPTION = Topic("/robot_description", types.TEXT, latched=True)
BODIES = Topic("/robot_bodies", types.MARKERS, latched=True)
FRAMES = Topic("/tf", types.TRANSFORMS)
CABLES = Topic("/cables", types.MARKERS)


class Shown(NamedTuple):
    """A robot that is looked at.

    Attributes:
        robot: The robot.
        folder: Folder of its files.
        roots: Folders whose files may be read; see `carried_files`.
        scene: What is around it; None for nothing.
    """

    robot: Robot
    folder: Path
    roots: tuple[Path, ...]
    scene: Scene | None = None

    @classmethod
    def of(cls, experiment: Experiment) -> Self:
        """That of an experiment, with its robot's files there."""
        return cls(experiment.robot, experiment.folder, experiment.roots, experiment.scene)


class SceneTopics:
    """The topics of a robot that is looked at.

    Args:
        shown: The robot.

    Attributes:
        topics: Its topics.
        meshes: The files of meshes that the robot's description names, by their places there.
        findings: The meshes that are left out.
    """

    topics = (DESCRIPTION, BODIES, FRAMES, CABLES)

    def __init__(self, shown: Shown) -> None:
        self._robot = robot = shown.robot
        self._world = shown.scene
        self._link_meshes = link_meshes(robot, shown.folder, shown.roots)
        self._stage = Stage(robot, Motion.still(_initial(robot)), self._link_meshes)
        carried = CarriedMeshes.of(robot, shown.folder)
        self.meshes = {
            name: mesh_bytes(file, [carried.folder]) for name, file in carried.files.items()
        }
        self.findings: list[Finding] = list(carried.losses(robot))
        package = f"package://{identifier(robot.name)}"
        named = {uri: f"{package}/{name}" for uri, name in carried.names.items()}
        described = CarriedMeshes(carried.folder, names=named).applied(robot, keeps_models=False)
        self._urdf = None if robot.driven_joints else urdf_text(described)
        if self._urdf is None:
            self.findings += URDF_ALONE.losses(robot)

    def first(self, time: FloatArray) -> Iterator[Batch]:
        """The description and the bodies of links, once, at a time of shape (1,), in [s]."""
        time_ns = nanoseconds(time)
        if self._urdf is not None:
            yield Batch(DESCRIPTION, time_ns, {"data": self._urdf})
        markers = list(body_markers(time_ns, self._robot, self._stage, self._link_meshes))
        yield Batch(BODIES, time_ns, {"markers": markers})

    def frame_rows(self, run: RunData) -> Rows:
        """Return the rows of a run that make frames: at an even rate, without those of no position.

        Raises:
            UnknownNameError: The run lacks a joint position.
        """
        rows = frame_rows(run["time"], RATE)
        known = np.isfinite(run.columns(coordinate_signals("q", self._robot))[rows]).all(axis=1)
        return rows[known]

    def highest(self, run: RunData, rows: Rows) -> float:
        """Return the largest tension in some rows, in [N]; 0 if none is known."""
        tensions = motion_of(self._robot, run, rows).tensions if len(rows) else None
        return 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))

    def batches(self, run: RunData, rows: Rows, highest: float) -> Iterator[Batch]:
        """Frames, cables and task points.

        Args:
            run: The run.
            rows: Rows with a position, of the frames.
            highest: The tension at which colours end, in [N].
        """
        if not len(rows):
            return
        robot, motion = self._robot, motion_of(self._robot, run, rows, self._world)
        time_ns = nanoseconds(motion.time)
        frames = [
            *frame_transforms(robot, motion.q),
            *((WORLD, name, T) for name, T in motion.objects.items()),
        ]
        moved = [transform_values(time_ns, parent, child, T) for parent, child, T in frames]
        yield Batch(FRAMES, time_ns, {"transforms": moved})
        poses = link_poses(robot, motion.q)
        paths = muscle_paths(robot, motion.q, poses)
        tasks = {p.name: moved_point(poses[p.link], p.position) for p in task_points(robot)}
        reach = self._stage.reach
        markers = [
            *cable_markers(time_ns, robot, paths, motion.tensions, highest, reach),
            *task_markers(time_ns, tasks, motion.y_d, reach),
        ]
        yield Batch(CABLES, time_ns, {"markers": markers})


def _initial(robot: Robot) -> list[float]:
    return [min(max(c.initial, c.lower), c.upper) for c in robot.coordinates]
