"""Side on which a muscle passes a wrap surface, for formats that define it by a direction.

This project stores the sense of rotation of the path, other formats a direction in the surface
frame. Both are equivalent at the initial values of the coordinates and near them.
"""

from __future__ import annotations

from collections.abc import Mapping

from ...model.link_poses import initial_poses
from ...model.muscle import Muscle, Wrap
from ...model.pose import Pose, Vector3
from ...model.robot import Robot
from ...model.rotations import apply, compose, dot, inverse, normalized, subtract


def side_direction(robot: Robot, muscle: Muscle, wrap: Wrap) -> Vector3:
    """Return the direction in which a muscle passes, from its sense of rotation about z.

    Returns:
        A unit vector in the frame of the surface. For a cylinder it is orthogonal to the z axis.
        For a sphere it lies in the plane through both points and the centre, in which the muscle
        stays.
    """
    start, end = _ends(robot, muscle, wrap)
    x, y, _ = subtract(end, start)
    if x == y == 0.0:  # parallel to the axis: both sides are equivalent
        return 1.0, 0.0, 0.0
    across = normalized((wrap.side * y, -wrap.side * x, 0.0))
    surface = robot.wrap_surface(wrap.surface)
    if surface.shape == "cylinder":
        return across
    along = normalized(subtract(end, start))
    foot = subtract(start, tuple(dot(start, along) * w for w in along))  # type: ignore[arg-type]
    x, y, z = normalized(foot)
    sign = 1.0 if dot(start, across) >= 0.0 else -1.0
    return (sign * x, sign * y, sign * z) if any(foot) else across


def is_shorter_path(robot: Robot, muscle: Muscle, wrap: Wrap) -> bool:
    """Return whether the straight line passes on the chosen side; see `side_direction`."""
    start, end = _ends(robot, muscle, wrap)
    return wrap.side * (start[0] * end[1] - start[1] * end[0]) >= 0.0


def _ends(robot: Robot, muscle: Muscle, wrap: Wrap) -> tuple[Vector3, Vector3]:
    return ends_on(robot, muscle, wrap, initial_poses(robot))


def ends_on(
    robot: Robot, muscle: Muscle, wrap: Wrap, poses: Mapping[str, Pose]
) -> tuple[Vector3, Vector3]:
    """Return the via points before and after a wrap, in the surface's frame.

    Args:
        wrap: A wrap of the muscle.
        poses: The pose of every link in the world.
    """
    surface = robot.wrap_surface(wrap.surface)
    T_surface_world = inverse(compose(poses[surface.link], surface.pose))
    start, end = (
        apply(T_surface_world, apply(poses[point.link], point.position))
        for point in muscle.via_points[wrap.segment : wrap.segment + 2]
    )
    return start, end
