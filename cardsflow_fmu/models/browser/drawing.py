"""Tables with which a page draws links from arrays of the C core."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from addin_sdfusion.robot import Robot
from sim_dart.calibration.inertia import inertia_numbers
from sim_dart.core.frames import moving_frames


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
        wrenched: Index of each link with an external wrench.
    """
    _, places = moving_frames(robot)
    links = [link.name for link in robot.links]
    poses = [places[name].T_frame_link for name in links]
    rows = [np.concatenate([T[:3, :3].ravel(), T[:3, 3]]) for T in poses]
    frames = [places[name].frame for name in links]
    indices = [links.index(name) for name in wrenched]
    return {
        "links": links,
        "frames": add(np.array(frames, dtype=np.int32)),
        "wrenched": add(np.array(indices, dtype=np.int32)),
        "places": add(np.array(rows, dtype=np.float64)),
    }


def link_moments(robot: Robot) -> NDArray[np.float64]:
    """Return mass, first and second moments of each link in its moving frame, shape (links, 10)."""
    _, places = moving_frames(robot)
    rows = [inertia_numbers(places[link.name].inertia(link.inertia)) for link in robot.links]
    return np.array(rows).reshape(-1, 10)
