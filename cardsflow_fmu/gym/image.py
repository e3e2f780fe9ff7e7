"""Images of a robot, drawn with NumPy: links as capsules, muscles coloured by their tension."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.camera import motion_plane
from cardsflow_fmu.results.viewer.scene.motion import Motion
from cardsflow_fmu.results.viewer.scene.stage import Stage
from cardsflow_fmu.utils.arrays import FloatArray

HEIGHT, WIDTH = 360, 480
_BACKGROUND = 250
_MARGIN = 1.1  # size of the view over that of the robot with any joint at its limits
_OBLIQUE = (1.0, -1.6, 0.7)
_GROUPS = (s.LINKS, s.MUSCLES)


class _Camera(NamedTuple):
    """Orthographic camera: rows of R are right, up and towards the viewer."""

    R: FloatArray
    centre: FloatArray
    scale: float


class _Segment(NamedTuple):
    """Segment in the image: its ends (right, up, depth), radius and colour."""

    start: FloatArray
    end: FloatArray
    radius: float
    colour: s.Colour


def image(robot: Robot, q: FloatArray, tensions: FloatArray) -> NDArray[np.uint8]:
    """Return an image of a robot.

    Args:
        robot: The robot.
        q: Joint positions, shape (n,), in [rad] or [m].
        tensions: Muscle forces, shape (m,), in [N].

    Returns:
        Red, green and blue, shape (360, 480, 3).
    """
    camera = _camera(robot)
    q, tensions = np.nan_to_num(q), np.nan_to_num(tensions)
    motion = Motion(np.zeros(1), q[None], tensions[None])
    stage = Stage(robot, motion, full_scale=True)
    pixels = np.full((HEIGHT, WIDTH, 3), _BACKGROUND, dtype=np.uint8)
    segments = sorted(_segments(stage, camera), key=lambda one: one.start[2] + one.end[2])
    for segment in segments:
        _draw(pixels, segment)
    return pixels


@lru_cache(maxsize=16)
def _camera(robot: Robot) -> _Camera:
    stage = Stage(robot, Motion(np.zeros(2 * len(robot.coordinates) + 1), _extremes(robot)))
    normal = motion_plane(stage)
    towards = np.array(_OBLIQUE) if normal is None else normal
    if normal is not None and normal @ np.array(_OBLIQUE) < 0.0:
        towards = -normal
    towards = towards / np.linalg.norm(towards)
    up = stage.up - (stage.up @ towards) * towards
    if np.linalg.norm(up) < 1e-6:  # the plane is horizontal
        up = np.array([0.0, 1.0, 0.0])
    up = up / np.linalg.norm(up)
    R = np.stack([np.cross(up, towards), up, towards])
    corners = np.array(list(itertools.product(*zip(*stage.box, strict=True))))
    centre = corners.mean(axis=0)
    seen = np.abs((corners - centre) @ R[:2].T).max(axis=0)
    scale = (np.array([WIDTH, HEIGHT]) / np.maximum(seen, 1e-6)).min()
    return _Camera(R, centre, scale / (2.0 * _MARGIN))


def _extremes(robot: Robot) -> FloatArray:
    """Return the initial pose, and this pose with each coordinate at each of its limits."""
    initial = Motion.initial(robot).q[0]
    rows = [initial]
    for k, coordinate in enumerate(robot.coordinates):
        for end in (coordinate.lower, coordinate.upper):
            row = initial.copy()
            row[k] = end if np.isfinite(end) else initial[k]
            rows.append(row)
    return np.array(rows)


def _segments(stage: Stage, camera: _Camera) -> Iterator[_Segment]:
    for shape in stage.scene(0):
        if shape.group not in _GROUPS:
            continue
        points, radius = shape.points, getattr(shape, "radius", None)
        if radius is None or not np.isfinite(points).all():
            continue
        seen = (points - camera.centre) @ camera.R.T * camera.scale
        seen[:, :2] += WIDTH / 2, HEIGHT / 2
        ends = [(seen[0], seen[0])] if len(seen) == 1 else itertools.pairwise(seen)
        for start, end in ends:
            yield _Segment(start, end, max(radius * camera.scale, 1.0), shape.colour)


def _draw(pixels: NDArray[np.uint8], segment: _Segment) -> None:
    """Fill all pixels within the radius of a segment, darker towards its edge."""
    (x0, y0), (x1, y1), r = segment.start[:2], segment.end[:2], segment.radius
    left, right = int(max(min(x0, x1) - r, 0)), int(min(max(x0, x1) + r + 2, WIDTH))
    low, high = int(max(min(y0, y1) - r, 0)), int(min(max(y0, y1) + r + 2, HEIGHT))
    if left >= right or low >= high:
        return
    x, y = np.arange(left, right)[None], np.arange(low, high)[:, None]
    length = (x1 - x0) ** 2 + (y1 - y0) ** 2
    along = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / (length or 1.0)
    share = np.clip(along, 0.0, 1.0)
    off = np.hypot(x - x0 - share * (x1 - x0), y - y0 - share * (y1 - y0)) / r
    inside = off <= 1.0
    light = (1.0 - 0.4 * off[inside] ** 2)[:, None]
    rows = pixels[HEIGHT - high : HEIGHT - low, left:right][::-1]  # y points up
    rows[inside] = (light * np.array(segment.colour)).astype(np.uint8)
