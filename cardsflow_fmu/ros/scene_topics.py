"""The topics of a run for those who look at it: description, frames, cables and bodies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Finding, Robot
from addin_sdfusion.robot.formats.urdf.write import urdf_text
from addin_sdfusion.robot.formats.writing.carried_meshes import CarriedMeshes
from addin_sdfusion.robot.formats.writing.common_losses import driven_joints
from addin_sdfusion.robot.mesh_files import mesh_bytes
from cardsflow_fmu.experiment.experiment import Experiment
from cardsflow_fmu.middleware import types
from cardsflow_fmu.middleware.cdr import Bytes, header, message_rows
from cardsflow_fmu.middleware.node import Topic
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.signals.ports import coordinate_signals, identifier, muscle_signals
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.viewer.scene.link_poses import link_poses
from cardsflow_fmu.viewer.scene.meshes import link_meshes
from cardsflow_fmu.viewer.scene.motion import Motion, frame_rows, motion_of
from cardsflow_fmu.viewer.scene.muscle_paths import MusclePath, muscle_paths
from cardsflow_fmu.viewer.scene.stage import Stage
from sim_dart import MusclePaths
from sim_dart.scene import Scene

from .markers import body_markers, cable_markers, point_markers
from .robot_frames import frame_transforms, transform_values
from .topics import Batch, nanoseconds

Rows = NDArray[np.int64]

RATE = 50.0
"""Frames a second."""

DESCRIPTION = Topic("/robot_description", types.TEXT, latched=True)
BODIES = Topic("/robot_bodies", types.MARKERS, latched=True)
FRAMES = Topic("/tf", types.TRANSFORMS)
CABLES = Topic("/cables", types.MARKERS)
TENDONS = Topic("/tendons", types.ROBOY_TENDON)


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

    topics = (DESCRIPTION, BODIES, FRAMES, CABLES, TENDONS)

    def __init__(self, shown: Shown) -> None:
        self._robot = robot = shown.robot
        self._world = shown.scene
        self._core = MusclePaths(robot)
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
            self.findings += driven_joints(robot, "The description, URDF,")

    def first(self, time_ns: int) -> Iterator[Batch]:
        """What stands from the beginning on: the description and the bodies of links."""
        when = np.array([time_ns])
        if self._urdf is not None:
            yield Batch(DESCRIPTION, when, message_rows(types.TEXT, {"data": self._urdf}, 1))
        markers = list(body_markers(when, self._robot, self._stage, self._link_meshes))
        yield Batch(BODIES, when, message_rows(types.MARKERS, {"markers": markers}, 1))

    def frame_rows(self, run: RunData) -> Rows:
        """The rows of a run that make frames: at an even rate, without those of no position.

        Raises:
            UnknownNameError: The run lacks a joint position.
        """
        rows = frame_rows(run["time"], RATE)
        known = np.isfinite(run.columns(coordinate_signals("q", self._robot))[rows]).all(axis=1)
        return rows[known]

    def highest(self, run: RunData, rows: Rows) -> float:
        """The largest tension in some rows, in [N]; 0 where none is known."""
        tensions = motion_of(self._robot, run, rows).tensions if len(rows) else None
        return 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))

    def batches(self, run: RunData, rows: Rows, highest: float) -> Iterator[Batch]:
        """Frames.

        Args:
            run: The run.
            rows: Rows with a position, of the frames.
            highest: The tension at which colours end, in [N].
        """
        if not len(rows):
            return
        robot, motion = self._robot, motion_of(self._robot, run, rows, self._world)
        time_ns = nanoseconds(motion.time)
        yield Batch(FRAMES, time_ns, self._frames(time_ns, motion))
        paths = muscle_paths(robot, motion.q, link_poses(robot, motion.q))
        reach = self._stage.reach
        markers = [
            *cable_markers(time_ns, robot, paths, motion.tensions, highest, reach),
            *point_markers(time_ns, robot, motion, reach),
        ]
        yield Batch(CABLES, time_ns, message_rows(types.MARKERS, {"markers": markers}, len(rows)))
        if robot.muscles:
            lengths = _known(run, muscle_signals("l", robot), rows)
            qd = _known(run, coordinate_signals("qd", robot), rows)
            yield Batch(TENDONS, time_ns, self._tendons(motion, paths, lengths, qd))

    def _frames(self, time_ns: NDArray[np.int64], motion: Motion) -> Bytes:
        moved = [
            transform_values(header(time_ns, parent), child, T)
            for parent, child, T in frame_transforms(self._robot, motion.q)
        ]
        moved += [
            transform_values(header(time_ns, WORLD), name, T) for name, T in motion.objects.items()
        ]
        return message_rows(types.TRANSFORMS, {"transforms": moved}, len(time_ns))

    def _tendons(
        self,
        motion: Motion,
        paths: list[MusclePath],
        lengths: FloatArray | None,
        qd: FloatArray | None,
    ) -> Bytes:
        robot, time_ns = self._robot, nanoseconds(motion.time)
        k = np.arange(len(time_ns))[:, np.newaxis]
        points = [path.points[k, path.via] for path in paths]
        nothing = np.full((len(time_ns), len(robot.muscles)), np.nan)
        values = {
            "header": header(time_ns, WORLD),
            "name": [muscle.name for muscle in robot.muscles],
            "force": nothing if motion.tensions is None else motion.tensions,
            "l": nothing if lengths is None else lengths,
            "ld": nothing if qd is None else self._length_rates(motion.q, qd),
            "number_of_viapoints": np.array([path.via.shape[1] for path in paths]),
            "viapoints": np.concatenate(points, axis=1),
        }
        return message_rows(types.ROBOY_TENDON, values, len(time_ns))

    def _length_rates(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """L q' of every muscle, shape (K, m), in [m/s]."""
        rows = zip(q, qd, strict=True)
        return np.stack([self._core.evaluate(at).jacobian @ rate for at, rate in rows])


def _known(run: RunData, names: list[str], rows: Rows) -> FloatArray | None:
    """Columns at some rows; None where one is missing."""
    return run.columns(names)[rows] if set(names) <= set(run.names) else None


def _initial(robot: Robot) -> list[float]:
    return [min(max(c.initial, c.lower), c.upper) for c in robot.coordinates]
