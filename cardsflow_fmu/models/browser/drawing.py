"""Tables with which a page draws links and muscle paths from arrays of the C core."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from sim_dart.core.composite_inertia import CompositeInertia
from sim_dart.core.frames import moving_frames
from sim_dart.core.path_fields import ordered_wraps, pulley_muscles


def drawing_tables(
    robot: Robot, wrenched: Sequence[str], add: Callable[[NDArray[Any]], list[int]]
) -> dict[str, Any]:
    """Return the tables of a robot.

    Args:
        wrenched: Names of the links with external wrenches.
        add: Adds an array of float64 or int32 to the packed files, and returns its place.

    Returns:
        links: Names of the links.
        frames: Index of the moving frame of each link, -1 for the world.
        places: Rotation and position of each link in its frame, shape (links, 12).
        points: Number of via points of each muscle.
        surfaces: Index of the surface of each wrap, in the order of the core.
        half_axes: Half axes of each surface if it is an ellipsoid, otherwise zeros; shape (s, 3).
        wrenched: Index of each link with an external wrench.
        pulleys, radii: Index of the muscle and radius of each pulley.
    """
    _, places = moving_frames(robot)
    links = [link.name for link in robot.links]
    poses = [places[name].T_frame_link for name in links]
    rows = [np.concatenate([T[:3, :3].ravel(), T[:3, 3]]) for T in poses]
    numbers = {surface.name: k for k, surface in enumerate(robot.wrap_surfaces)}
    half_axes = [
        (surface.radius, *surface.half_axes) if surface.half_axes else (0.0, 0.0, 0.0)
        for surface in robot.wrap_surfaces
    ]
    pulleys = pulley_muscles(robot)
    pulley_radii = [robot.muscles[k].pulley.radius[0] for k in pulleys]  # type: ignore[union-attr]
    integers: dict[str, list[int]] = {
        "frames": [places[name].frame for name in links],
        "points": [len(muscle.via_points) for muscle in robot.muscles],
        "surfaces": [numbers[each.wrap.surface] for each in ordered_wraps(robot)],
        "pulleys": list(pulleys),
        "wrenched": [links.index(name) for name in wrenched],
    }
    reals = {"places": rows, "half_axes": half_axes, "radii": pulley_radii}
    return {
        "links": links,
        **{key: add(np.array(values, dtype=np.int32)) for key, values in integers.items()},
        **{key: add(np.array(values, dtype=np.float64)) for key, values in reals.items()},
    }


def link_moments(robot: Robot) -> NDArray[np.float64]:
    """Return mass, first and second moments of each link in its moving frame, shape (links, 10)."""
    _, places = moving_frames(robot)
    rows = []
    for link in robot.links:
        body = CompositeInertia()
        body.add(link.inertia, places[link.name].T_frame_link)
        rows.append(body.moments)
    return np.array(rows).reshape(-1, 10)
