"""Fields of the blob for conditional and moving via points, branches and other wrap rules."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import (
    CardsflowError,
    Muscle,
    PointCondition,
    PointMotion,
    Polynomial,
    Robot,
    Wrap,
)
from addin_sdfusion.robot.model.function import Cubic, cubics, value
from addin_sdfusion.robot.model.rotations import rotation

from .frames import Place
from .variables import robot_variables

_RULES = ("taut", "mujoco", "opensim")
"""Wrap rules in the order of `enum rule` of layout.h."""
_MAX_COEFFICIENTS = 4


class PlacedWrap(NamedTuple):
    """A wrap with its muscle and its position on the path."""

    muscle: Muscle
    wrap: Wrap
    point: int


def ordered_wraps(robot: Robot) -> list[PlacedWrap]:
    """Return the wraps of the active muscles, in their order along the paths."""
    return [
        PlacedWrap(muscle, wrap, first + wrap.segment)
        for muscle, first in zip(robot.muscles, first_points(robot), strict=True)
        for wrap in sorted(muscle.wraps, key=lambda wrap: wrap.segment)
    ]


def first_points(robot: Robot) -> list[int]:
    """Return the index of the first via point of each active muscle, counted over all muscles."""
    return list(accumulate((len(muscle.via_points) for muscle in robot.muscles), initial=0))[:-1]


class _Route(NamedTuple):
    """A muscle with its index and the index of its first via point."""

    number: int
    first: int
    muscle: Muscle


def route_counts(robot: Robot) -> dict[str, int]:
    """Return the number of items of each field."""
    points = [point for muscle in robot.muscles for point in muscle.via_points]
    moves = [move for point in points for move in point.moves]
    return {
        "guides": len(_guided_wraps(robot)),
        "conditions": sum(p.when is not None and not _is_always_met(robot, p.when) for p in points),
        "moves": len(moves),
        "pieces": sum(len(_pieces(robot, move)) for move in moves),
        "branches": sum(len(muscle.branches) for muscle in robot.muscles),
        "path_terms": sum(len(muscle.terms) for muscle in robot.muscles),
    }


def route_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    """Return the fields by name.

    Args:
        robot: A valid robot.
        places: Place of every link, from `moving_frames`.

    Raises:
        CardsflowError: A muscle path uses a feature that is not supported.
    """
    muscles = enumerate(zip(first_points(robot), robot.muscles, strict=True))
    routes = [_Route(number, first, muscle) for number, (first, muscle) in muscles]
    return {
        **_rule_fields(robot),
        **_guide_fields(robot, places),
        **_condition_fields(robot, routes),
        **_move_fields(robot, routes, places),
        "branch_point": [r.first + branch.point for r in routes for branch in r.muscle.branches],
        "branch_divisor": [branch.divisor for r in routes for branch in r.muscle.branches],
        "path_term_muscle": [r.number for r in routes for _ in r.muscle.terms],
        "path_term_coordinate": [
            _length_variable(robot, r.muscle, term.coordinate)
            for r in routes
            for term in r.muscle.terms
        ],
        "path_term_factor": [term.factor for r in routes for term in r.muscle.terms],
    }


def _guided_wraps(robot: Robot) -> list[Wrap]:
    """Return the wraps whose side is specified by a side point or a quadrant."""
    wraps = [placed.wrap for placed in ordered_wraps(robot)]
    return [wrap for wrap in wraps if wrap.side_point is not None or wrap.quadrant != "all"]


def _rule_fields(robot: Robot) -> dict[str, ArrayLike]:
    guides = {id(wrap): k for k, wrap in enumerate(_guided_wraps(robot))}
    placed = ordered_wraps(robot)
    return {
        "wrap_last": [p.point - p.wrap.segment + p.wrap.last for p in placed],
        "wrap_rule": [_RULES.index(p.wrap.rule) for p in placed],
        "wrap_guide": [guides.get(id(p.wrap), -1) for p in placed],
    }


def _guide_fields(robot: Robot, places: Mapping[str, Place]) -> dict[str, ArrayLike]:
    surfaces = {surface.name: surface for surface in robot.wrap_surfaces}
    frames, vectors = [], []
    for wrap in _guided_wraps(robot):
        if wrap.side_point is not None:
            place = places[wrap.side_point.link]
            vectors.append(place.point(wrap.side_point.position))
        else:
            surface = surfaces[wrap.surface]
            place = places[surface.link]
            axis = np.array(rotation(surface.pose.rpy))[:, "xyz".index(wrap.quadrant[1])]
            sign = -1.0 if wrap.quadrant[0] == "-" else 1.0
            vectors.append(sign * place.T_frame_link[:3, :3] @ axis)
        frames.append(place.frame)
    return {"guide_frame": frames, "guide_vector": vectors}


def _condition_fields(robot: Robot, routes: list[_Route]) -> dict[str, ArrayLike]:
    conditions = [
        (r, r.first + k, point.when)
        for r in routes
        for k, point in enumerate(r.muscle.via_points)
        if point.when is not None and not _is_always_met(robot, point.when)
    ]
    ends = [_condition_range(robot, r.muscle, when) for r, _, when in conditions]
    return {
        "condition_point": [k for _, k, _ in conditions],
        "condition_coordinate": [
            _coordinate_variable(robot, r.muscle, w.coordinate) for r, _, w in conditions
        ],
        "condition_low": [low for low, _ in ends],
        "condition_high": [high for _, high in ends],
        "condition_smoothing": [when.smoothing for _, _, when in conditions],
    }


def _move_fields(
    robot: Robot, routes: list[_Route], places: Mapping[str, Place]
) -> dict[str, ArrayLike]:
    moves = [
        (r, r.first + k, places[point.link], move)
        for r in routes
        for k, point in enumerate(r.muscle.via_points)
        for move in point.moves
    ]
    pieces = [_pieces(robot, move) for _, _, _, move in moves]
    counts = [len(each) for each in pieces]
    return {
        "move_point": [k for _, k, _, _ in moves],
        "move_coordinate": [
            _coordinate_variable(robot, r.muscle, m.coordinate) for r, _, _, m in moves
        ],
        "move_axis": [place.T_frame_link[:3, :3] @ np.array(m.axis) for _, _, place, m in moves],
        "move_low": [move.low for _, _, _, move in moves],
        "move_high": [move.high for _, _, _, move in moves],
        "move_first": np.cumsum([0, *counts])[:-1],
        "move_pieces": counts,
        "piece": [piece for each in pieces for piece in each],
    }


def _fixed_value(robot: Robot, name: str) -> float | None:
    """Return the value of a fixed coordinate, or None if the coordinate moves."""
    variables = robot_variables(robot)
    return None if name in variables.index else variables.initial[name]


def _is_always_met(robot: Robot, when: PointCondition) -> bool:
    """Return whether the coordinate of a condition is fixed inside the condition's range."""
    at = _fixed_value(robot, when.coordinate)
    return at is not None and when.low <= at <= when.high


def _condition_range(robot: Robot, muscle: Muscle, when: PointCondition) -> tuple[float, float]:
    """Return the range of a condition; an empty range if its coordinate is fixed outside of it."""
    at = _fixed_value(robot, when.coordinate)
    if at is None:
        return when.low, when.high
    if max(when.low - at, at - when.high) < when.smoothing:
        raise _fixed_coordinate_error(muscle, when.coordinate)
    return math.inf, math.inf


def _pieces(robot: Robot, move: PointMotion) -> tuple[Cubic, ...]:
    function = move.function
    at = _fixed_value(robot, move.coordinate)
    if at is not None:
        return ((0.0, value(function, min(max(at, move.low), move.high)), 0.0, 0.0, 0.0),)
    if not isinstance(function, Polynomial):
        return cubics(function)
    if len(function.coefficients) > _MAX_COEFFICIENTS:
        problem = f"a via point with a polynomial of {len(function.coefficients)} coefficients"
        raise CardsflowError(
            f"{problem} is not supported in simulation; use at most {_MAX_COEFFICIENTS}"
        )
    a, b, c, d = (*function.coefficients, 0.0, 0.0, 0.0)[:_MAX_COEFFICIENTS]
    return ((0.0, a, b, c, d),)


def _length_variable(robot: Robot, muscle: Muscle, name: str) -> int:
    """Return the index of the variable of a coordinate that a muscle length depends on."""
    variables = robot_variables(robot)
    variable = variables.index.get(name, variables.constants.get(name))
    if variable is None:
        raise _fixed_coordinate_error(muscle, name)
    return variable


def _coordinate_variable(robot: Robot, muscle: Muscle, name: str) -> int:
    """Return the index of the variable of a coordinate; 0 if the coordinate is fixed."""
    index = robot_variables(robot).index
    if not index:
        raise _fixed_coordinate_error(muscle, name)
    return index.get(name, 0)


def _fixed_coordinate_error(muscle: Muscle, name: str) -> CardsflowError:
    problem = f"its path depends on the fixed coordinate {name!r}"
    return CardsflowError(f"muscle {muscle.name!r}: {problem}; this is not supported in simulation")
