"""Shapes of a run at any frame."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Robot
from cardsflow_fmu.utils.arrays import FloatArray
from sim_dart.core.frames import transform
from sim_dart.scene import Scene

from . import colours
from . import shapes as s
from .environment import Environment
from .link_bodies import link_capsules, platform_hull
from .link_poses import coordinate_axes, link_poses, moved_point
from .meshes import LinkMeshes
from .motion import Motion, task_points
from .muscle_paths import MusclePath, muscle_paths, stump, unit_forces
from .shapes import Triangles
from .solids import shape_triangles
from .trail import trail_points
from .wrap_surfaces import wrap_shape

_NEAR = 0.05
"""Maximum distance of joints with stacked labels, as fraction of the reach."""

_UPRIGHT = 0.999

_TRAIL_RADIUS = 0.0045
"""Radius of the spheres of a trail, as fraction of the reach."""


class Stage:
    """Robot and motion with the geometry of all frames.

    All frames have shapes with the same names. Some shapes may have zero size.

    Args:
        meshes: Surfaces of the links. Other links are drawn as capsules, with their collision
            shapes, and as the convex hull of their muscle attachments if these span an area, as on
            platforms.
        world: Objects and ground around the robot.
        full_scale: Whether colours range to f_max instead of the maximum tension of the motion.

    Attributes:
        robot, motion, meshes: Arguments of the constructor.
        poses: Poses of the links.
        environment: Objects and ground around the robot.
        box: Two opposite corners of a box around the robot and its meshes in all frames, in [m].
        reach: Length of the diagonal of the box, in [m].
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
        self.meshes = meshes or {}
        bare = [link for link in robot.links if link.name not in self.meshes and link.shapes]
        self._solids = {link.name: tuple(map(shape_triangles, link.shapes)) for link in bare}
        self.poses = link_poses(robot, motion.q)
        self._paths = muscle_paths(robot, motion.q, self.poses)
        self._unit_forces = [unit_forces(path) for path in self._paths]
        self._tips = {
            frame.name: moved_point(self.poses[frame.link], frame.position)
            for frame in task_points(robot)
        }
        self.environment = Environment(world, motion.objects)
        self.box = self._box()
        self.reach = float(np.linalg.norm(self.box[1] - self.box[0])) or 1.0
        self._joints = [self.poses[j.child] @ transform(j.T_child_joint) for j in robot.joints]
        self._label_rows = self._stacked_labels()
        self._full_scale = full_scale

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.motion.time)

    @property
    def muscle_lengths(self) -> FloatArray:
        """Lengths of the drawn muscle paths, shape (K, m), in [m]."""
        steps = [np.diff(path.points, axis=1) for path in self._paths]
        lengths = [np.linalg.norm(step, axis=2).sum(axis=1) for step in steps]
        return np.stack(lengths, axis=1) if lengths else np.zeros((len(self), 0))

    def scene(self, k: int) -> list[s.Shape]:
        """Return the shapes of frame k."""
        return [
            *self._links(k),
            *self.environment.shapes(k, self.box),
            *self._wrap_surfaces(k),
            *self._muscles(k),
            *self._forces(k),
            *self._torques(k),
            *self._frames(k),
            *self._labels(k),
            *self._contacts(k),
            *self._paths_of_points(k),
        ]

    def tension_range(self, muscle: int) -> tuple[float, float]:
        """Return the tensions at both ends of the colour ramp of a muscle, in [N]."""
        low, high = self.robot.muscles[muscle].f_min, self.robot.muscles[muscle].f_max
        if self._full_scale and np.isfinite(high):
            return low, high
        return low, min(high, max(self.max_tension, low))

    @cached_property
    def reference(self) -> dict[str, FloatArray]:
        """Desired path of each end-effector point, shape (K, 3), in [m], by task frame."""
        motion = self.motion
        if motion.q_d is not None and motion.q_d.shape[1]:
            poses = link_poses(self.robot, motion.q_d)
            return {f.name: moved_point(poses[f.link], f.position) for f in task_points(self.robot)}
        return {
            name: np.where(np.isnan(points), self._tips[name], points)
            for name, points in motion.y_d.items()
        }

    @cached_property
    def max_tension(self) -> float:
        """Maximum tension of the motion, in [N]."""
        tensions = self.motion.tensions
        return 0.0 if tensions is None else float(np.nanmax(tensions, initial=0.0))

    def _box(self) -> tuple[FloatArray, FloatArray]:
        points = [T[:, :3, 3] for name, T in self.poses.items() if name != WORLD]
        points += [path.points.reshape(-1, 3) for path in self._paths]
        points += [moved_point(self.poses[link], corner) for link, corner in self._mesh_corners()]
        all_points = np.concatenate([*points, *self._tips.values()])
        all_points = all_points[np.isfinite(all_points).all(axis=1)]
        if not len(all_points):
            return np.zeros(3), np.zeros(3)
        return all_points.min(axis=0), all_points.max(axis=0)

    def _mesh_corners(self) -> Iterator[tuple[str, tuple[float, float, float]]]:
        """Yield the corners of the bounding box of each mesh, in the link frame."""
        for link, meshes in (*self.meshes.items(), *self._solids.items()):
            for mesh in meshes:
                low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
                for x, y, z in product(*zip(low.tolist(), high.tolist(), strict=True)):
                    yield link, (x, y, z)

    @cached_property
    def _hulls(self) -> dict[str, Triangles]:
        """Hulls of links without a mesh, if their muscle attachments span an area, by link name."""
        bare = [link for link in self.robot.links if link.name not in self.meshes]
        hulls = {link.name: platform_hull(self.robot, link, 0.01 * self.reach) for link in bare}
        return {name: hull for name, hull in hulls.items() if hull is not None}

    @cached_property
    def _trails(self) -> dict[str, tuple[FloatArray, NDArray[np.int64]]]:
        """Trail of each end-effector point, and the number of trail points at each frame."""
        distance = 3.0 * _TRAIL_RADIUS * self.reach
        return {name: trail_points(path, distance) for name, path in self._tips.items()}

    def _stacked_labels(self) -> list[int]:
        """Return the number of labels below the label of each joint, for joints at one position."""
        positions = [T[0, :3, 3] for T in self._joints]
        rows: list[int] = []
        for k, joint in enumerate(self.robot.joints):
            below = [
                rows[i] + len(self.robot.joints[i].coordinates)
                for i in range(k)
                if np.linalg.norm(positions[i] - positions[k]) < _NEAR * self.reach
            ]
            rows.append(max(below, default=0) if joint.coordinates else 0)
        return rows

    def _links(self, k: int) -> Iterator[s.Shape]:
        reach = self.reach
        for link in self.robot.links:
            T = self.poses[link.name][k]
            if link.name in self.meshes:
                for i, mesh in enumerate(self.meshes[link.name]):
                    key = f"{link.name}/{i}"
                    colour = mesh.colour or colours.LINK
                    yield s.MeshShape(s.LINKS, key, colour, T, mesh, lever=reach / 2)
                continue
            if link.name in self._hulls:
                key, hull = f"{link.name}/hull", self._hulls[link.name]
                yield s.MeshShape(s.LINKS, key, colours.LINK, T, hull, lever=reach / 2)
            capsules, solids = (
                list(link_capsules(self.robot, link)),
                self._solids.get(link.name, ()),
            )
            for i, solid in enumerate(solids, len(capsules)):
                key = f"{link.name}/{i}"
                yield s.MeshShape(s.LINKS, key, colours.LINK, T, solid, lever=reach / 2)
            for i, ends in enumerate(capsules):
                a, b = (T[:3, :3] @ end + T[:3, 3] for end in ends)
                yield s.Capsule(s.LINKS, f"{link.name}/{i}", colours.LINK, a, b, 0.01 * reach)
        for joint, poses in zip(self.robot.joints, self._joints, strict=True):
            if joint.motions and joint.child not in self.meshes:
                key, centre = f"joint {joint.name}", poses[k, :3, 3]
                yield s.Sphere(s.LINKS, key, colours.JOINT, centre, 0.015 * reach)

    def _wrap_surfaces(self, k: int) -> Iterator[s.Shape]:
        for surface in self.robot.wrap_surfaces:
            T = self.poses[surface.link][k] @ transform(surface.pose)
            yield wrap_shape(surface, T, self.reach)

    def _muscles(self, k: int) -> Iterator[s.Shape]:
        reach = self.reach
        for i, (muscle, path) in enumerate(zip(self.robot.muscles, self._paths, strict=True)):
            colour = colours.SLACK
            if self.motion.tensions is not None:
                tension = float(self.motion.tensions[k, i])
                colour = colours.tension_colour(tension, *self.tension_range(i))
            points = path.points[k]
            if self.motion.broken is not None and self.motion.broken[k, i]:
                points, colour = stump(points), colours.SLACK
            yield s.Line(s.MUSCLES, muscle.name, colour, points, 0.004 * reach)
            for v, corner in enumerate(path.via[k]):
                key, centre = f"{muscle.name}/{v}", path.points[k, corner]
                yield s.Sphere(s.VIA_POINTS, key, colours.VIA_POINT, centre, 0.007 * reach)

    def _forces(self, k: int) -> Iterator[s.Shape]:
        """Yield muscle forces at via points; the largest force of the run has a fixed length."""
        if self.motion.tensions is None:
            return
        per_newton = 0.16 * self.reach / (self.max_tension or 1.0)
        for i, muscle in enumerate(self.robot.muscles):
            tension = max(float(np.nan_to_num(self.motion.tensions[k, i])), 0.0)
            path: MusclePath = self._paths[i]
            for v, corner in enumerate(path.via[k]):
                start = path.points[k, corner]
                end = start + per_newton * tension * self._unit_forces[i][k, v]
                key, radius = f"{muscle.name}/{v}", 0.0026 * self.reach
                yield s.Arrow(s.FORCES, key, colours.FORCE, start, end, radius)

    def _torques(self, k: int) -> Iterator[s.Shape]:
        """Yield motor torques along their axes (right-hand rule); the largest has a fixed length.

        Torques and forces have different scales.
        """
        torques = self.motion.torques
        if torques is None:
            return
        for i, (motor, (points, axes)) in enumerate(
            zip(self.robot.motors, self._motor_axes, strict=True)
        ):
            same = [j for j, m in enumerate(self.robot.motors) if m.unit == motor.unit]
            largest = float(np.nanmax(np.abs(torques[:, same]), initial=0.0))
            length = 0.16 * self.reach / (largest or 1.0) * float(np.nan_to_num(torques[k, i]))
            start, end = points[k], points[k] + length * axes[k]
            key = f"motor/{motor.name}"
            yield s.Arrow(s.FORCES, key, colours.MOTOR, start, end, 0.004 * self.reach)

    @cached_property
    def _motor_axes(self) -> list[tuple[FloatArray, FloatArray]]:
        axes = coordinate_axes(self.robot, self.motion.q, self.poses)
        return [axes[motor.name] for motor in self.robot.motors]

    def _frames(self, k: int) -> Iterator[s.Shape]:
        for joint, poses in zip(self.robot.joints, self._joints, strict=True):
            if joint.motions:
                yield self._frame(s.JOINT_FRAMES, joint.name, poses[k], 0.08)
        for link in self.robot.links:
            yield self._frame(s.LINK_FRAMES, link.name, self.poses[link.name][k], 0.11)
        yield self._frame(s.LINK_FRAMES, WORLD, np.eye(4), 0.14)

    def _frame(self, group: str, key: str, T: FloatArray, scale: float) -> s.Frame:
        return s.Frame(group, key, colours.TEXT, T, scale * self.reach, 0.003 * self.reach)

    def _labels(self, k: int) -> Iterator[s.Shape]:
        q = iter(self.motion.q[k].tolist())
        for joint, poses, row in zip(
            self.robot.joints, self._joints, self._label_rows, strict=True
        ):
            for i, c in enumerate(c for c in joint.coordinates if c.is_free):
                above = (0.055 + 0.04 * (row + i)) * self.reach * self.up
                position = poses[k, :3, 3] + above
                yield s.Label(
                    s.JOINT_VALUES, c.name, colours.TEXT, position, c.name, next(q), c.unit
                )

    @cached_property
    def up(self) -> FloatArray:
        """Unit vector against gravity; z axis if gravity is zero."""
        gravity = np.array(self.robot.gravity)
        size = np.linalg.norm(gravity)
        up: FloatArray = -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
        return up

    @property
    def floor(self) -> float | None:
        """Height of the ground, in [m]; None if it is not horizontal or does not exist."""
        return self.environment.floor if self.up[2] > _UPRIGHT else None

    def _contacts(self, k: int) -> Iterator[s.Shape]:
        """Yield the contact force at the centre of each body; the largest has a fixed length."""
        contacts = self.motion.contacts
        largest = max(
            (float(np.nanmax(np.abs(f), initial=0.0)) for f in contacts.values()), default=0
        )
        per_newton, radius = 0.2 * self.reach / (largest or 1.0), 0.003 * self.reach
        for name, forces in contacts.items():
            com = self._centre(name, k)
            start = com - per_newton * np.nan_to_num(forces[k])
            yield s.Arrow(s.CONTACTS, name, colours.CONTACT, start, com, radius)

    def _centre(self, name: str, k: int) -> FloatArray:
        """Return the centre of mass of a link, or the position of an object, in [m]."""
        if name in self.environment.positions:
            positions = self.environment.positions[name]
        else:
            positions = moved_point(self.poses[name], self.robot.link(name).inertia.com)
        middle: FloatArray = positions[min(k, len(positions) - 1)]
        return middle

    def _paths_of_points(self, k: int) -> Iterator[s.Shape]:
        for name, path in self.reference.items():
            yield s.Line(s.REFERENCE, name, colours.REFERENCE, path, 0.002 * self.reach)
        if len(self) == 1:
            return
        for name, (centres, passed) in self._trails.items():
            path = centres[: passed[k]]
            yield s.Trail(s.TRAIL, name, colours.TRAIL, path, _TRAIL_RADIUS * self.reach)
