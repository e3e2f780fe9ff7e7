"""Variables of a robot: its coordinates q and all values that are functions of q.

x = phi(q) contains first q, then the coupled coordinates, each after the coordinates that it
depends on. Last are the displacements of motions that are driven by a function, or by a coordinate
that also drives another motion.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import Coordinate, Joint, Motion, Polynomial, Robot
from addin_sdfusion.robot.model.coupling import all_values, followers
from addin_sdfusion.robot.model.function import ITSELF, Function, cubics, value
from addin_sdfusion.robot.model.robot import cached_on_robot

from .arrays import FloatArray

_POLYNOMIAL, _PIECES = 0, 1
"""Values of `enum term` of layout.h."""


@dataclass(frozen=True)
class FunctionTerm:
    """A function of one variable. The value of another variable is a sum of such terms."""

    source: int
    function: Function


@dataclass(frozen=True)
class Variables:
    """The variables of a robot.

    Attributes:
        coordinates: The variables that are coordinates, in order; the first are q.
        terms: The terms of each variable, in order; empty for q.
        driver: Index of the variable that drives each motion, by joint name; None if the motion is
            constant.
        constant: Displacement of each constant motion, by joint name.
        index: Index of the variable of each moving coordinate, by name.
        constants: Index of the variable of each fixed coordinate that a muscle length depends on.
        initial: Initial value of every coordinate, in [rad] or [m], by name.
    """

    coordinates: tuple[Coordinate, ...]
    terms: tuple[tuple[FunctionTerm, ...], ...]
    driver: dict[str, tuple[int | None, ...]]
    constant: dict[str, tuple[float, ...]]
    index: dict[str, int]
    constants: dict[str, int]
    initial: dict[str, float]


@cached_on_robot
def robot_variables(robot: Robot) -> Variables:
    """Return the variables of a valid robot."""
    moving = {c.name for c in robot.coordinates}
    coupled = []
    for c in followers(robot):
        if any(term.coordinate in moving for term in c.coupling):
            moving.add(c.name)
            coupled.append(c)
    coordinates = (*robot.coordinates, *coupled)
    index = {c.name: k for k, c in enumerate(coordinates)}
    values = all_values(robot, {c.name: c.initial for c in robot.coordinates})
    terms: list[tuple[FunctionTerm, ...]] = [() for _ in robot.coordinates]
    terms += [_coupling(c, index, values) for c in coupled]
    driver, constant = {}, {}
    direct: set[int] = set()
    for joint in robot.joints:
        drivers = [_driver(joint, motion, index, terms, direct) for motion in joint.motions]
        driver[joint.name] = tuple(drivers)
        constant[joint.name] = tuple(_constant(joint, motion, values) for motion in joint.motions)
    counted = {t.coordinate for m in robot.muscles for t in m.terms if t.coordinate not in index}
    constants = {}
    for name in sorted(counted) if index else ():
        constants[name] = len(terms)
        terms.append((FunctionTerm(0, Polynomial((values[name],))),))
    return Variables(coordinates, tuple(terms), driver, constant, index, constants, values)


def _driver(
    joint: Joint,
    motion: Motion,
    index: dict[str, int],
    terms: list[tuple[FunctionTerm, ...]],
    direct: set[int],
) -> int | None:
    """Return the index of the variable that drives a motion; append a variable if necessary."""
    if motion.is_fixed:
        return None
    variable = index.get(joint.coordinates[motion.coordinate].name)
    if variable is None:
        return None
    if motion.function == ITSELF and variable not in direct:
        direct.add(variable)
        return variable
    terms.append((FunctionTerm(variable, motion.function),))
    return len(terms) - 1


def _constant(joint: Joint, motion: Motion, values: dict[str, float]) -> float:
    if motion.is_fixed:
        return motion.displacement(0.0)
    return motion.displacement(values[joint.coordinates[motion.coordinate].name])


def _coupling(
    c: Coordinate, index: dict[str, int], values: dict[str, float]
) -> tuple[FunctionTerm, ...]:
    """Return the terms of a coupled coordinate; fixed coordinates are combined to a constant."""
    moving = [
        FunctionTerm(index[term.coordinate], term.function)
        for term in c.coupling
        if term.coordinate in index
    ]
    others = (term for term in c.coupling if term.coordinate not in index)
    constant = sum(value(term.function, values[term.coordinate]) for term in others)
    if constant:
        moving.append(FunctionTerm(moving[0].source, Polynomial((constant,))))
    return tuple(moving)


def variable_fields(variables: Variables) -> dict[str, ArrayLike]:
    """Return the fields of the blob for variables."""
    terms = [term for group in variables.terms for term in group]
    numbers = [_numbers(term.function) for term in terms]
    more = [0.0] * (len(variables.terms) - len(variables.coordinates))
    fields: dict[str, ArrayLike] = {
        name: [*(getattr(c, name) for c in variables.coordinates), *more]
        for name in ("damping", "stiffness", "rest", "armature")
    }
    forces = _limit_forces(variables)
    return fields | {
        "limit_variable": [index for index, _ in forces],
        "limit_numbers": [numbers for _, numbers in forces],
        "variable_terms": [len(group) for group in variables.terms],
        "term_source": [term.source for term in terms],
        "term_kind": [
            _POLYNOMIAL if isinstance(t.function, Polynomial) else _PIECES for t in terms
        ],
        "term_size": [len(row) for row in numbers],
        "term_number": np.concatenate([row.ravel() for row in numbers]) if numbers else [],
    }


def variable_counts(variables: Variables) -> dict[str, int]:
    """Return the number of items of these fields."""
    terms = [term for group in variables.terms for term in group]
    return {
        "variables": len(variables.terms),
        "terms": len(terms),
        "limit_forces": len(_limit_forces(variables)),
        "term_numbers": sum(_numbers(term.function).size for term in terms),
    }


def _limit_forces(variables: Variables) -> list[tuple[int, tuple[float, ...]]]:
    """Return the index of the variable of each limit force, and its parameters."""
    return [
        (k, astuple(c.limit_force))
        for k, c in enumerate(variables.coordinates)
        if c.limit_force is not None
    ]


def _numbers(function: Function) -> FloatArray:
    """Return the numbers of a function, one row per coefficient or piece."""
    if isinstance(function, Polynomial):
        return np.array(function.coefficients, dtype=float)
    return np.array(cubics(function), dtype=float)


def variable_values(variables: Variables, q: FloatArray) -> FloatArray:
    """Return all variables at several poses.

    Args:
        variables: The variables of a robot.
        q: Shape (K, n), in [rad] or [m].

    Returns:
        Shape (K, number of variables).
    """
    values = np.zeros((len(q), len(variables.terms)))
    values[:, : q.shape[1]] = q
    for k, group in enumerate(variables.terms):
        for term in group:
            values[:, k] += _evaluate(term.function, values[:, term.source])
    return values


def _evaluate(function: Function, x: FloatArray) -> FloatArray:
    numbers = _numbers(function)
    if isinstance(function, Polynomial):
        return np.asarray(np.polynomial.polynomial.polyval(x, numbers))
    at, a, b, c, d = numbers[np.searchsorted(numbers[1:, 0], x, side="right")].T
    D = x - at
    return np.asarray(a + D * (b + D * (c + D * d)))
