"""Poses of a robot in which its loops are closed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from addin_sdfusion.robot import InputError, Robot, UnknownNameError
from addin_sdfusion.robot.checks.check import require_valid

from .arrays import FloatArray, finite
from .blob import compile_blob
from .library import Core
from .loop_fields import closures


def close_loops(robot: Robot, q: ArrayLike | None = None, hold: Sequence[str] = ()) -> FloatArray:
    """Return the nearest pose in which all loops of a robot are closed, within its joints' limits.

    A pose without gaps comes back as it is. Where a start leads into a dead end, others near it
    are tried, always the same.

    Args:
        robot: The robot.
        q: Where to begin, shape (n,), in [rad] or [m]; at the initial values when None.
        hold: Names of coordinates that stay where they are.

    Returns:
        Shape (n,), in [rad] or [m].

    Raises:
        RobotError: The robot is not valid.
        InputError: They cannot be closed; the message names a joint and its gap.
        UnknownNameError: There is no such coordinate.
    """
    names = [c.name for c in require_valid(robot).coordinates]
    for name in hold:
        if name not in names:
            raise UnknownNameError("coordinate", name, names)
    start = [c.initial for c in robot.coordinates] if q is None else q
    held = np.array([float(name in hold) for name in names])
    return closed_pose(robot, Core(compile_blob(robot)), finite("q", start, len(names)), held)


def closed_pose(
    robot: Robot, core: Core, q: FloatArray, held: FloatArray | None = None
) -> FloatArray:
    """As `close_loops`, in a core that the robot is opened in, and that goes there."""
    closed = q.copy()
    address = None if held is None else held.ctypes.data
    bad = core.close(core.handle, address, closed.ctypes.data)
    if bad:
        equations = closures(robot)
        gap = abs(core.array("closure_gap", len(equations))[bad - 1])
        equation = equations[bad - 1]
        problem = f"its loop cannot be closed: it stays open by {gap:.2g} {equation.unit}"
        raise InputError(f"joint {equation.loop.name!r}: {problem}, {_listed(robot, closed)}")
    return closed


def closed_rates(core: Core, qd: FloatArray) -> FloatArray:
    """Return the velocities nearest to some that keep the loops closed, at the last pose."""
    rates = qd.copy()
    core.close_rates(core.handle, rates.ctypes.data)
    return rates


def _listed(robot: Robot, q: FloatArray, most: int = 5) -> str:
    values = [f"{c.name} = {x:.3g}" for c, x in zip(robot.coordinates, q, strict=True)]
    return "at " + ", ".join(values[:most]) + (", ..." if len(values) > most else "")
