"""Topics that visualise a run: robot description, frames, cables and bodies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Finding, Robot
from addin_sdfusion.robot.formats.urdf.capabilities import URDF_WITHOUT_EXTRAS
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
"""Frame rate, in [Hz]."""

DESCRIPTION = Topic("/robot_description", types.TEXT, latched=True)
BODIES = Topic("/robot_bodies", types.MARKERS, latched=True)
FRAMES = Topic("/tf", types.TRANSFORMS)
CABLES = Topic("/cables", types.MARKERS)


class ShownRobot(NamedTuple):
    """Robot to visualise.

    Attributes:
        folder: Folder of the robot's files.
        roots: Folders with files that may be read; see `packed_files`.
        scene: Surroundings of the robot, or None.
    """

    robot: Robot
    folder: Path
    roots: tuple[Path, ...]
    scene: Scene | None = None

    @classmethod
    def from_experiment(cls, experiment: Experiment) -> Self:
        """Return the robot of an experiment."""
        return cls(experiment.robot, experiment.folder, experiment.roots, experiment.scene)


class SceneTopics:
    """Topics that visualise a robot.

    Attributes:
        meshes: Contents of the mesh files, by their path in the robot description.
        findings: Notes about omitted meshes and an omitted description.
    """

    topics = (DESCRIPTION, BODIES, FRAMES, CABLES)

    def __init__(self, shown: ShownRobot) -> None:
        self._robot = robot = shown.robot
        self._world = shown.scene
        self._link_meshes = link_meshes(robot, shown.folder, shown.roots)
        self._stage = Stage(robot, Motion.initial(robot), self._link_meshes)
        carried = CarriedMeshes.of(robot, shown.folder)
        self.meshes = {
            name: mesh_bytes(file, [carried.folder]) for name, file in carried.files.items()
        }
        self.findings: list[Finding] = list(carried.losses(robot))
        package = f"package://{identifier(robot.name)}"
        named = {uri: f"{package}/{name}" for uri, name in carried.names.items()}
        described = CarriedMeshes(carried.folder, names=named).apply_to(robot, keeps_models=False)
        self._urdf = None if robot.driven_joints else urdf_text(described)
        if self._urdf is None:
            self.findings += URDF_WITHOUT_EXTRAS.losses(robot)

    def first(self, time: FloatArray) -> Iterator[Batch]:
        """Yield the robot description and the bodies of links.

        Args:
            time: Time of the messages, shape (1,), in [s].
        """
        time_ns = nanoseconds(time)
        if self._urdf is not None:
            yield Batch(DESCRIPTION, time_ns, {"data": self._urdf})
        markers = list(body_markers(time_ns, self._robot, self._stage, self._link_meshes))
        yield Batch(BODIES, time_ns, {"markers": markers})

    def frame_rows(self, run: RunData) -> Rows:
        """Return the rows of a run to visualise, at a fixed rate.

        Rows with joint positions that are not finite are omitted.
        """
        rows = frame_rows(run["time"], RATE)
        is_finite = np.isfinite(run.columns(coordinate_signals("q", self._robot))[rows]).all(axis=1)
        return rows[is_finite]

    def max_tension(self, run: RunData, rows: Rows) -> float:
        """Return the maximum tension in the given rows, in [N], or 0 if tensions are unknown."""
        tensions = motion_of(self._robot, run, rows).tensions if len(rows) else None
        return 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))

    def batches(self, run: RunData, rows: Rows, max_tension: float) -> Iterator[Batch]:
        """Yield frames, cables and task points.

        Args:
            rows: Rows to visualise, from `frame_rows`.
            max_tension: Tension at the end of the colour scale, in [N].
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
            *cable_markers(time_ns, robot, paths, motion.tensions, max_tension, reach),
            *task_markers(time_ns, tasks, motion.y_d, reach),
        ]
        yield Batch(CABLES, time_ns, {"markers": markers})
