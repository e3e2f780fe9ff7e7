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

_MAX_VALUES = 5  # of a pose in a message


def close_loops(robot: Robot, q: ArrayLike | None = None, hold: Sequence[str] = ()) -> FloatArray:
    """Return the nearest pose in which all loops of a robot are closed, within its joints' limits.

    If the loops are closed at q, return q unchanged. If the search fails from q, it is repeated
    from other start poses near q. These are the same in every call.

    Args:
        q: Start pose, shape (n,), in [rad] or [m] (default: the initial values).
        hold: Names of coordinates that keep their values.

    Returns:
        The closed pose, shape (n,), in [rad] or [m].

    Raises:
        RobotError: The robot is not valid.
        InputError: The loops cannot be closed; the message contains a joint and its gap.
        UnknownNameError: A coordinate does not exist.
    """
    names = [c.name for c in require_valid(robot).coordinates]
    for name in hold:
        if name not in names:
            raise UnknownNameError("coordinate", name, names)
    start = [c.initial for c in robot.coordinates] if q is None else q
    is_held = np.array([float(name in hold) for name in names])
    return closed_pose(robot, Core(compile_blob(robot)), finite("q", start, len(names)), is_held)


def closed_pose(
    robot: Robot, core: Core, q: FloatArray, is_held: FloatArray | None = None
) -> FloatArray:
    """Return the nearest closed pose, computed by an open core, and set the core to this pose.

    Args:
        core: Core that was created from this robot.
        q: Start pose, shape (n,), in [rad] or [m].
        is_held: 1 for coordinates that keep their values, 0 for the others, shape (n,) (default:
            all zero).

    Raises:
        InputError: The loops cannot be closed.
    """
    closed = q.copy()
    address = None if is_held is None else is_held.ctypes.data
    bad = core.close(core.handle, address, closed.ctypes.data)
    if bad:
        equations = closures(robot)
        gap = abs(core.array("closure_gap", len(equations))[bad - 1])
        equation = equations[bad - 1]
        problem = f"its loop cannot be closed; the remaining gap is {gap:.2g} {equation.unit}"
        raise InputError(f"joint {equation.loop.name!r}: {problem}, {_format_pose(robot, closed)}")
    return closed


def remaining_gap(robot: Robot, core: Core) -> float:
    """Return the largest gap of the loops after `closed_pose`, in [m] or [rad].

    It is above 1e-10 if positions in the robot's files contradict each other by up to 1e-6, for
    example the planes of a planar loop.
    """
    count = len(closures(robot))
    return float(np.abs(core.array("closure_gap", count)).max()) if count else 0.0


def closed_rates(core: Core, qd: FloatArray) -> FloatArray:
    """Return the velocities nearest to qd that keep the loops closed at the core's last pose."""
    rates = qd.copy()
    core.close_rates(core.handle, rates.ctypes.data)
    return rates


def _format_pose(robot: Robot, q: FloatArray) -> str:
    values = [f"{c.name} = {x:.3g}" for c, x in zip(robot.coordinates, q, strict=True)]
    ending = ", ..." if len(values) > _MAX_VALUES else ""
    return "at " + ", ".join(values[:_MAX_VALUES]) + ending
