"""scene(robot, result, k) -> shapes: everything that there is to see of a run at one moment."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Robot
from cardsflow_fmu.results.run_data import RunData
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.scene import Scene

from . import colours
from . import shapes as s
from .environment import Surroundings
from .link_capsules import bones
from .link_poses import link_poses, moved_point
from .meshes import LinkMeshes
from .motion import Motion, frame_rows, motion_of, task_points
from .muscle_paths import MusclePath, muscle_paths, pulls
from .trail import beads_along
from .wrap_surfaces import wrap_shape

_NEAR = 0.05
"""Joints nearer than this part of the robot's reach have their labels one above another."""

_UPRIGHT = 0.999

_BEAD = 0.0045
"""Radius of a sphere of the trail, as a part of the robot's reach."""


def scene(robot: Robot, result: RunData, k: int, world: Scene | None = None) -> list[s.Shape]:
    """What there is to see at row k of a result. For many rows, keep a `Stage`.

    Args:
        robot: The robot of the run.
        result: What the run gave.
        k: The row.
        world: What stands around the robot.

    Raises:
        InputError: The result does not hold what is needed, or has no such row.
    """
    rows = frame_rows(result["time"])
    with_k = np.union1d(rows, [range(len(result.rows))[k]]) if len(result.rows) else rows
    stage = Stage(robot, motion_of(robot, result, with_k, world), world=world)
    return stage.scene(int(np.searchsorted(with_k, k % max(len(result.rows), 1))))


class Stage:
    """A robot and its motion, from which any frame can be drawn; geometry is computed at once.

    Every frame has the same shapes, by their names: what is not there has no size.

    Args:
        robot: The robot.
        motion: Its motion.
        meshes: What its links look like; capsules take the place of those that are missing.
        world: What stands around the robot.
        full_scale: Whether colours reach to f_max, instead of the largest tension of the motion.

    Attributes:
        robot, motion: As given.
        around: What stands around the robot.
        box: The two corners of the box that holds the robot in all its frames, in [m].
        reach: The diagonal of that box, in [m].
    """

    def __init__(
        self,
        robot: Robot,
        motion: Motion,
        meshes: LinkMeshes | None = None,
        *,
        world: Scene | None = None,
        full_scale: bool = False,
    ) -> None:
        self.robot, self.motion = robot, motion
        self._meshes = meshes or {}
        self._poses = link_poses(robot, motion.q)
        self._paths = muscle_paths(robot, motion.q, self._poses)
        self._pulls = [pulls(path) for path in self._paths]
        self._tips = {
            frame.name: moved_point(self._poses[frame.link], frame.position)
            for frame in task_points(robot)
        }
        self.around = Surroundings(world, motion.objects)
        self.box = self._box()
        self.reach = float(np.linalg.norm(self.box[1] - self.box[0])) or 1.0
        self._joints = self._joint_poses()
        self._label_rows = self._stacked_labels()
        self._full_scale = full_scale

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.motion.time)

    def scene(self, k: int) -> list[s.Shape]:
        """The shapes of frame k."""
        return [
            *self._links(k),
            *self.around.shapes(k, self.box),
            *self._wrap_surfaces(k),
            *self._muscles(k),
            *self._forces(k),
            *self._frames(k),
            *self._labels(k),
            *self._contacts(k),
            *self._ways(k),
        ]

    def tension_range(self, muscle: int) -> tuple[float, float]:
        """Where the colours of a muscle begin and end, in [N]: f_min, and f_max or less.

        No muscle comes near an f_max that is generous: the largest tension of the motion then has
        the last colour.

        Args:
            muscle: Its index.
        """
        low, high = self.robot.muscles[muscle].f_min, self.robot.muscles[muscle].f_max
        if self._full_scale and np.isfinite(high):
            return low, high
        return low, min(high, max(self._largest_tension, low))

    @cached_property
    def reference(self) -> dict[str, FloatArray]:
        """The way that each task point is to go, shape (K, 3), by the frame's name."""
        motion = self.motion
        if motion.q_d is not None and motion.q_d.shape[1]:
            poses = link_poses(self.robot, motion.q_d)
            return {f.name: moved_point(poses[f.link], f.position) for f in task_points(self.robot)}
        return {
            name: np.where(np.isnan(points), self._tips[name], points)
            for name, points in motion.y_d.items()
        }

    @cached_property
    def _largest_tension(self) -> float:
        tensions = self.motion.tensions
        return 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))

    def _box(self) -> tuple[FloatArray, FloatArray]:
        places = [T[:, :3, 3] for T in self._poses.values()]
        places += [path.points.reshape(-1, 3) for path in self._paths]
        everything = np.concatenate([*places, *self._tips.values()])
        everything = everything[np.isfinite(everything).all(axis=1)]
        if not len(everything):
            return np.zeros(3), np.zeros(3)
        return everything.min(axis=0), everything.max(axis=0)

    @cached_property
    def _beads(self) -> dict[str, tuple[FloatArray, NDArray[np.int64]]]:
        """The trail of each task point: beads along its way, and how many each frame has passed."""
        return {
            name: beads_along(way, 3.0 * _BEAD * self.reach) for name, way in self._tips.items()
        }

    def _joint_poses(self) -> list[FloatArray]:
        """The frame behind the motions of every joint, shape (K, 4, 4), in their order."""
        return [self._poses[j.child] @ transform(j.T_child_joint) for j in self.robot.joints]

    def _stacked_labels(self) -> list[int]:
        """For every joint, how many labels of joints at the same place stand below its own."""
        places = [T[0, :3, 3] for T in self._joints]
        rows: list[int] = []
        for k, joint in enumerate(self.robot.joints):
            below = [
                rows[i] + len(self.robot.joints[i].coordinates)
                for i in range(k)
                if np.linalg.norm(places[i] - places[k]) < _NEAR * self.reach
            ]
            rows.append(max(below, default=0) if joint.coordinates else 0)
        return rows

    def _links(self, k: int) -> Iterator[s.Shape]:
        for link in self.robot.links:
            T = self._poses[link.name][k]
            if link.name in self._meshes:
                for i, triangles in enumerate(self._meshes[link.name]):
                    yield s.MeshShape(
                        name=f"links/{link.name}/{i}",
                        group=s.LINKS,
                        colour=colours.LINK,
                        T=T,
                        triangles=triangles,
                        lever=self.reach / 2,
                    )
                continue
            for i, (a, b) in enumerate(bones(self.robot, link)):
                yield s.Capsule(
                    name=f"links/{link.name}/{i}",
                    group=s.LINKS,
                    colour=colours.LINK,
                    start=T[:3, :3] @ a + T[:3, 3],
                    end=T[:3, :3] @ b + T[:3, 3],
                    radius=0.01 * self.reach,
                )
        for joint, poses in zip(self.robot.joints, self._joints, strict=True):
            if joint.motions and joint.child not in self._meshes:
                yield s.Sphere(
                    name=f"links/joint {joint.name}",
                    group=s.LINKS,
                    colour=colours.JOINT,
                    centre=poses[k, :3, 3],
                    radius=0.015 * self.reach,
                )

    def _wrap_surfaces(self, k: int) -> Iterator[s.Shape]:
        for surface in self.robot.wrap_surfaces:
            T = self._poses[surface.link][k] @ transform(surface.pose)
            yield wrap_shape(surface, T, self.reach)

    def _muscles(self, k: int) -> Iterator[s.Shape]:
        for i, (muscle, path) in enumerate(zip(self.robot.muscles, self._paths, strict=True)):
            colour = colours.SLACK
            if self.motion.tensions is not None:
                tension = float(self.motion.tensions[k, i])
                colour = colours.tension_colour(tension, *self.tension_range(i))
            yield s.Line(
                name=f"muscles/{muscle.name}",
                group=s.MUSCLES,
                colour=colour,
                path=path.points[k],
                radius=0.004 * self.reach,
            )
            for v, corner in enumerate(path.via[k]):
                yield s.Sphere(
                    name=f"via points/{muscle.name}/{v}",
                    group=s.VIA_POINTS,
                    colour=colours.VIA_POINT,
                    centre=path.points[k, corner],
                    radius=0.007 * self.reach,
                )

    def _forces(self, k: int) -> Iterator[s.Shape]:
        """What the muscles do at their via points; the largest pull of all has a fixed length."""
        if self.motion.tensions is None:
            return
        per_newton = 0.16 * self.reach / (self._largest_tension or 1.0)
        for i, muscle in enumerate(self.robot.muscles):
            tension = max(float(np.nan_to_num(self.motion.tensions[k, i])), 0.0)
            path: MusclePath = self._paths[i]
            for v, corner in enumerate(path.via[k]):
                start = path.points[k, corner]
                yield s.Arrow(
                    name=f"forces/{muscle.name}/{v}",
                    group=s.FORCES,
                    colour=colours.FORCE,
                    start=start,
                    end=start + per_newton * tension * self._pulls[i][k, v],
                    radius=0.0026 * self.reach,
                )

    def _frames(self, k: int) -> Iterator[s.Shape]:
        for joint, poses in zip(self.robot.joints, self._joints, strict=True):
            if joint.motions:
                yield self._frame(f"joint frames/{joint.name}", s.JOINT_FRAMES, poses[k], 0.08)
        for link in self.robot.links:
            poses = self._poses[link.name]
            yield self._frame(f"link frames/{link.name}", s.LINK_FRAMES, poses[k], 0.11)
        yield self._frame(f"link frames/{WORLD}", s.LINK_FRAMES, np.eye(4), 0.14)

    def _frame(self, name: str, group: str, T: FloatArray, part: float) -> s.Frame:
        length, radius = part * self.reach, 0.003 * self.reach
        return s.Frame(
            name=name, group=group, colour=colours.TEXT, T=T, length=length, radius=radius
        )

    def _labels(self, k: int) -> Iterator[s.Shape]:
        column = 0
        for joint, poses, row in zip(
            self.robot.joints, self._joints, self._label_rows, strict=True
        ):
            for i, coordinate in enumerate(joint.coordinates):
                above = (0.055 + 0.04 * (row + i)) * self.reach * self.up
                yield s.Label(
                    name=f"joint values/{coordinate.name}",
                    group=s.JOINT_VALUES,
                    colour=colours.TEXT,
                    position=poses[k, :3, 3] + above,
                    title=coordinate.name,
                    value=float(self.motion.q[k, column]),
                    unit=coordinate.unit,
                )
                column += 1

    @cached_property
    def up(self) -> FloatArray:
        """Against gravity, a unit vector; z where nothing falls."""
        gravity = np.array(self.robot.gravity)
        size = np.linalg.norm(gravity)
        up: FloatArray = -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        return up

    @property
    def floor(self) -> float | None:
        """Height of a ground that things fall onto, in [m]."""
        return self.around.floor if self.up[2] > _UPRIGHT else None

    def _contacts(self, k: int) -> Iterator[s.Shape]:
        """The contact force on a body, ending at its middle; the largest has a fixed length."""
        contacts = self.motion.contacts
        largest = max(
            (float(np.nanmax(np.abs(f), initial=0.0)) for f in contacts.values()), default=0
        )
        for name, forces in contacts.items():
            com = self._middle(name, k)
            yield s.Arrow(
                name=f"contacts/{name}",
                group=s.CONTACTS,
                colour=colours.CONTACT,
                start=com - 0.2 * self.reach / (largest or 1.0) * np.nan_to_num(forces[k]),
                end=com,
                radius=0.003 * self.reach,
            )

    def _middle(self, name: str, k: int) -> FloatArray:
        """The centre of mass of a link, or the place of an object."""
        if name in self.around.places:
            places = self.around.places[name]
        else:
            places = moved_point(self._poses[name], self.robot.link(name).inertia.com)
        middle: FloatArray = places[min(k, len(places) - 1)]
        return middle

    def _ways(self, k: int) -> Iterator[s.Shape]:
        for name, way in self.reference.items():
            yield s.Line(
                name=f"reference/{name}",
                group=s.REFERENCE,
                colour=colours.REFERENCE,
                path=way,
                radius=0.002 * self.reach,
            )
        if len(self) == 1:
            return
        for name, (beads, passed) in self._beads.items():
            yield s.Trail(
                name=f"trail/{name}",
                group=s.TRAIL,
                colour=colours.TRAIL,
                path=beads[: passed[k]],
                radius=_BEAD * self.reach,
            )
