"""Markers for RViz: cables coloured by tension, task points, and the bodies of links."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import WORLD, Robot
from cardsflow_fmu.results.viewer.scene import colours
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.link_poses import link_poses
from cardsflow_fmu.results.viewer.scene.meshes import LinkMeshes
from cardsflow_fmu.results.viewer.scene.muscle_paths import MusclePath
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.ros_interface.node import Values, header
from cardsflow_fmu.utils.arrays import FloatArray

from .robot_frames import point_values, pose_values, urdf_frames

_SPHERE, _CYLINDER, _LINE_STRIP, _TRIANGLES = 2, 3, 4, 11
_LINE_WIDTH, _POINT_SIZE = 0.006, 0.03  # as fractions of the robot's reach


def cable_markers(
    time_ns: NDArray[np.int64],
    robot: Robot,
    paths: Sequence[MusclePath],
    tensions: FloatArray | None,
    max_tension: float,
    reach: float,
) -> Iterator[Values]:
    """Yield a line strip for each muscle, coloured by its tension.

    Args:
        time_ns: Times of K frames, shape (K,), in [ns].
        tensions: Tensions, shape (K, m), in [N], or None if unknown.
        max_tension: Maximum tension of the motion, in [N].
        reach: Reach of the robot, in [m].
    """
    for k, (muscle, path) in enumerate(zip(robot.muscles, paths, strict=True)):
        pull = np.full(len(time_ns), np.nan) if tensions is None else tensions[:, k]
        top = min(muscle.f_max, max(max_tension, muscle.f_min))
        yield {
            **_marker(header(time_ns, WORLD), "cables", k, _LINE_STRIP),
            "scale": {"x": _LINE_WIDTH * reach},
            "color": _colour(colours.tension_colours(pull, muscle.f_min, top).T),
            "points": path.points,
        }


def task_markers(
    time_ns: NDArray[np.int64],
    tasks: Mapping[str, FloatArray],
    desired: Mapping[str, FloatArray],
    reach: float,
) -> Iterator[Values]:
    """Yield a sphere for each end-effector point, and one for its reference.

    Args:
        time_ns: Times of K frames, shape (K,), in [ns].
        tasks: Positions by name, shape (K, 3) each, in [m].
        desired: Desired positions by name, shape (K, 3) each, in [m]; NaN for axes without a
            reference.
        reach: Reach of the robot, in [m].
    """
    for k, (name, position) in enumerate(tasks.items()):
        spheres = {"task points": (position, colours.TRAIL)}
        if name in desired:
            reference = np.where(np.isnan(desired[name]), position, desired[name])
            spheres["desired"] = reference, colours.REFERENCE
        for group, (centre, colour) in spheres.items():
            yield {
                **_marker(header(time_ns, WORLD), group, k, _SPHERE),
                "pose": {"position": point_values(centre), "orientation": {"w": 1.0}},
                "scale": dict.fromkeys("xyz", _POINT_SIZE * reach),
                "color": _colour(colour),
            }


def body_markers(
    time_ns: NDArray[np.int64], robot: Robot, stage: Stage, meshes: LinkMeshes
) -> Iterator[Values]:
    """Yield markers for the bodies of links, in the URDF frames of the links.

    Meshes and convex hulls are triangles; capsules are cylinders.

    Args:
        time_ns: Time of the markers, shape (1,), in [ns].
        stage: Scene of the robot at any joint positions.
    """
    poses = link_poses(robot, stage.motion.q[:1])
    frames = urdf_frames(robot)
    links = [shape for shape in stage.scene(0) if shape.group == s.LINKS]
    for k, shape in enumerate(links):
        if not isinstance(shape, s.MeshShape | s.Capsule):
            continue  # spheres that represent joints
        link = shape.key.rpartition("/")[0]
        T_frame_link = _inverse(frames[link])
        values: dict[str, Any] = {
            **_marker(header(time_ns, link), "links", k, _TRIANGLES),
            "frame_locked": True,
            "color": _colour(shape.colour),
        }
        if isinstance(shape, s.MeshShape):
            corners = shape.triangles.vertices[shape.triangles.faces].reshape(1, -1, 3)
            yield values | {
                "pose": pose_values(T_frame_link[np.newaxis]),
                "scale": dict.fromkeys("xyz", 1.0),
                "points": corners,
            }
        else:
            T_link_world = _inverse(poses[link][0])
            T, length = _between(T_frame_link @ T_link_world, shape.start, shape.end)
            width = 2.0 * shape.radius
            yield values | {
                "type": _CYLINDER,
                "pose": pose_values(T[np.newaxis]),
                "scale": {"x": width, "y": width, "z": length},
            }


def _inverse(T: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.inv(T), dtype=np.float64)


def _between(T: FloatArray, start: FloatArray, end: FloatArray) -> tuple[FloatArray, float]:
    """Return the pose and the length of a cylinder between two points transformed by T."""
    a, b = (T[:3, :3] @ point + T[:3, 3] for point in (start, end))
    length = float(np.linalg.norm(b - a))
    z = (b - a) / length if length else np.array([0.0, 0.0, 1.0])
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    pose[:3, 3] = (a + b) / 2.0
    return pose, length


def _marker(head: Values, group: str, number: int, kind: int) -> dict[str, Any]:
    return {
        "header": head,
        "ns": group,
        "id": number,
        "type": kind,
        "pose": {"orientation": {"w": 1.0}},
    }


def _colour(rgb: Any) -> dict[str, Any]:
    """Return the fields of a `ColorRGBA`."""
    return {name: value / 255.0 for name, value in zip("rgb", rgb, strict=True)} | {"a": 1.0}
