"""Fields of the blob for muscle paths: via points, wrap surfaces, wraps and pulleys."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Robot, WrapSurface
from addin_sdfusion.robot.model.rotations import rotation

from .arrays import FloatArray
from .frames import Place
from .route_fields import first_points, ordered_wraps, route_counts, route_fields

_KINDS = ("sphere", "cylinder", "ellipsoid")
_INSIDE = 2
"""WRAP_INSIDE of layout.h."""


def pulley_muscles(robot: Robot) -> list[int]:
    """Return the indices of the active muscles that start at a swivelling pulley."""
    return [k for k, muscle in enumerate(robot.muscles) if muscle.pulley is not None]


def path_counts(robot: Robot) -> dict[str, int]:
    """Return the number of items of each field."""
    return {
        "points": sum(len(muscle.via_points) for muscle in robot.muscles),
        "surfaces": len(robot.wrap_surfaces),
        "wraps": len(ordered_wraps(robot)),
        "pulleys": len(pulley_muscles(robot)),
        "bends": sum(len(muscle.bend_friction) for muscle in robot.muscles),
        **route_counts(robot),
    }


def path_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    """Return the fields for muscle paths by name."""
    points = [point for muscle in robot.muscles for point in muscle.via_points]
    return {
        "muscle_points": [len(muscle.via_points) for muscle in robot.muscles],
        "muscle_bends": [len(muscle.bend_friction) for muscle in robot.muscles],
        "bend_friction": [mu for muscle in robot.muscles for mu in muscle.bend_friction],
        "presliding": [muscle.presliding for muscle in robot.muscles],
        "point_frame": [places[point.link].frame for point in points],
        "point_position": [places[point.link].point(point.position) for point in points],
        **_surface_fields(robot, places),
        **_wrap_fields(robot),
        **_pulley_fields(robot, places),
        **route_fields(robot, places),
    }


def _surface_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    surfaces = robot.wrap_surfaces
    ended = [s.shape == "cylinder" and math.isfinite(s.length) for s in surfaces]
    return {
        "surface_kind": [_KINDS.index(surface.shape) for surface in surfaces],
        "surface_frame": [places[surface.link].frame for surface in surfaces],
        "surface_centre": [places[s.link].point(s.pose.position) for s in surfaces],
        "surface_axis": [_axis(places[s.link], s, 2) for s in surfaces],
        "surface_across": [_axis(places[s.link], s, 0) for s in surfaces],
        "surface_radius": [surface.radius for surface in surfaces],
        "surface_half_axes": [surface.half_axes or (0.0, 0.0) for surface in surfaces],
        "surface_half": [s.length / 2 if e else 0.0 for s, e in zip(surfaces, ended, strict=True)],
    }


def _wrap_fields(robot: Robot) -> dict[str, ArrayLike]:
    placed = ordered_wraps(robot)
    surfaces = {surface.name: k for k, surface in enumerate(robot.wrap_surfaces)}
    return {
        "wrap_point": [each.point for each in placed],
        "wrap_surface": [surfaces[each.wrap.surface] for each in placed],
        "wrap_side": [_INSIDE if each.wrap.inside else each.wrap.side for each in placed],
        "wrap_turns": [each.wrap.turns for each in placed],
    }


def _pulley_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    firsts, muscles = first_points(robot), robot.muscles
    on = pulley_muscles(robot)
    pulleys = [pulley for muscle in muscles if (pulley := muscle.pulley) is not None]
    return {
        "pulley_point": [firsts[k] for k in on],
        "pulley_direction": [
            _rotate_direction(places[muscles[k].via_points[0].link], pulley.entry_vector)
            for k, pulley in zip(on, pulleys, strict=True)
        ],
        "pulley_radius": [pulley.radius[0] for pulley in pulleys],
    }


def _axis(place: Place, surface: WrapSurface, k: int) -> FloatArray:
    """Return the x, y or z axis (k = 0, 1, 2) of a surface in its moving frame."""
    return _rotate_direction(place, tuple(row[k] for row in rotation(surface.pose.rpy)))


def _rotate_direction(place: Place, direction: tuple[float, ...]) -> FloatArray:
    """Return a direction given in a link frame as a unit vector in the moving frame."""
    turned: FloatArray = place.T_frame_link[:3, :3] @ np.array(direction)
    return turned / np.linalg.norm(turned)
