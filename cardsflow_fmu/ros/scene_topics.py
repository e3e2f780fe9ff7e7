"""The topics of a run for those who look at it: description, frames, cables and bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from addin_sdfusion.robot import WORLD, Finding, Robot
from addin_sdfusion.robot.mesh_files import mesh_bytes
from addin_sdfusion.robot.writers.carried_meshes import CarriedMeshes
from addin_sdfusion.robot.writers.common_losses import driven_joints
from addin_sdfusion.robot.writers.urdf import urdf_text
from cardsflow_fmu.results.run_data import ExperimentRunData
from cardsflow_fmu.signals.ports import coordinate_signals, identifier, muscle_signals
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.viewer.scene.link_poses import link_poses
from cardsflow_fmu.viewer.scene.meshes import link_meshes
from cardsflow_fmu.viewer.scene.motion import Motion, frame_rows, motion_of
from cardsflow_fmu.viewer.scene.muscle_paths import MusclePath, muscle_paths
from cardsflow_fmu.viewer.scene.stage import Stage
from sim_dart import MusclePaths

from . import types
from .cdr import header, message_rows
from .markers import body_markers, cable_markers, point_markers
from .robot_frames import frame_transforms, transform_values
from .topics import Batch, Topic, nanoseconds

RATE = 50.0
"""Frames a second."""

DESCRIPTION = Topic("/robot_description", types.TEXT, latched=True)
BODIES = Topic("/robot_bodies", types.MARKERS, latched=True)
FRAMES = Topic("/tf", types.TRANSFORMS)
CABLES = Topic("/cables", types.MARKERS)
TENDONS = Topic("/tendons", types.ROBOY_TENDON)


class SceneTopics:
    """The topics of a run with its robot.

    Args:
        run: The run, with its robot's files there.

    Attributes:
        topics: Its topics.
        meshes: The files of meshes that the robot's description names, by their places there.
        findings: The meshes that are left out.

    Raises:
        InputError: The run has no rows, or lacks a joint position.
    """

    topics = (DESCRIPTION, BODIES, FRAMES, CABLES, TENDONS)

    def __init__(self, run: ExperimentRunData) -> None:
        experiment = run.experiment
        self._robot = robot = experiment.robot
        rows = frame_rows(run["time"], RATE)
        known = np.isfinite(run.columns(coordinate_signals("q", robot))[rows]).all(axis=1)
        self._rows = rows[known]
        self._motion = motion_of(robot, run, self._rows, experiment.scene)
        self._time_ns = nanoseconds(self._motion.time)
        self._lengths = _known(run, muscle_signals("l", robot), self._rows)
        self._rates = _known(run, coordinate_signals("qd", robot), self._rows)
        self._core = MusclePaths(robot)
        self._link_meshes = link_meshes(robot, experiment.folder, experiment.roots)
        first = Motion.still(self._motion.q[0] if len(self._rows) else _initial(robot))
        self._stage = Stage(robot, first, self._link_meshes)
        tensions = self._motion.tensions
        self._highest = 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))
        carried = CarriedMeshes.of(robot, experiment.folder)
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

    def batches(self, first: int, end: int) -> Iterator[Batch]:
        """The frames within the rows from `first` to before `end`."""
        a, b = np.searchsorted(self._rows, [first, end]).tolist()
        if a == b:
            return
        frames, robot, motion = slice(a, b), self._robot, self._motion
        time_ns, q = self._time_ns[frames], motion.q[frames]
        tensions = None if motion.tensions is None else motion.tensions[frames]
        yield Batch(FRAMES, time_ns, self._frames(frames))
        paths = muscle_paths(robot, q, link_poses(robot, q))
        reach = self._stage.reach
        markers = [
            *cable_markers(time_ns, robot, paths, tensions, self._highest, reach),
            *point_markers(time_ns, robot, motion, frames, reach),
        ]
        yield Batch(CABLES, time_ns, message_rows(types.MARKERS, {"markers": markers}, b - a))
        if robot.muscles:
            yield Batch(TENDONS, time_ns, self._tendons(frames, paths, tensions))

    def _frames(self, frames: slice) -> np.ndarray:
        time_ns = self._time_ns[frames]
        moved = [
            transform_values(header(time_ns, parent), child, T)
            for parent, child, T in frame_transforms(self._robot, self._motion.q[frames])
        ]
        moved += [
            transform_values(header(time_ns, WORLD), name, T[frames])
            for name, T in self._motion.objects.items()
        ]
        return message_rows(types.TRANSFORMS, {"transforms": moved}, len(time_ns))

    def _tendons(
        self, frames: slice, paths: list[MusclePath], tensions: FloatArray | None
    ) -> np.ndarray:
        robot, time_ns = self._robot, self._time_ns[frames]
        k = np.arange(len(time_ns))[:, np.newaxis]
        points = [path.points[k, path.via] for path in paths]
        nothing = np.full((len(time_ns), len(robot.muscles)), np.nan)
        values = {
            "header": header(time_ns, WORLD),
            "name": [muscle.name for muscle in robot.muscles],
            "force": nothing if tensions is None else tensions,
            "l": nothing if self._lengths is None else self._lengths[frames],
            "ld": nothing if self._rates is None else self._length_rates(frames, self._rates),
            "number_of_viapoints": np.array([path.via.shape[1] for path in paths]),
            "viapoints": np.concatenate(points, axis=1),
        }
        return message_rows(types.ROBOY_TENDON, values, len(time_ns))

    def _length_rates(self, frames: slice, qd: FloatArray) -> FloatArray:
        """L q' of every muscle, shape (K, m), in [m/s]."""
        rows = zip(self._motion.q[frames], qd[frames], strict=True)
        return np.stack([self._core.evaluate(q).jacobian @ rate for q, rate in rows])


def _known(run: ExperimentRunData, names: list[str], rows: np.ndarray) -> FloatArray | None:
    """Columns at some rows; None where one is missing."""
    return run.columns(names)[rows] if set(names) <= set(run.names) else None


def _initial(robot: Robot) -> list[float]:
    return [c.initial for c in robot.coordinates]
