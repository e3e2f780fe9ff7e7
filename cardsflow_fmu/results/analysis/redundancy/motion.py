"""Given motions of a robot, as input of the analysis of muscle redundancy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import InputError, Robot
from addin_sdfusion.robot.transforms.lock import lock
from cardsflow_fmu.experiment.config.names import Names
from cardsflow_fmu.experiment.recorded_motion import read_recorded, recorded_names
from cardsflow_fmu.utils.arrays import FloatArray
from controllers.analysis.inverse_dynamics import Motion
from controllers.references.splines import SplineReference

MAX_FRAMES = 10000


@dataclass(frozen=True, eq=False)
class ExternalLoads:
    """Wrenches on links along a motion, world axes, about the origins of the links.

    Attributes:
        links: k names of links; a link may occur several times.
        forces: Shape (T, k, 3), in [N].
        moments: Shape (T, k, 3), in [N·m].
        generalised: Generalised forces, shape (T, n), in [N·m] or [N].
    """

    links: tuple[str, ...]
    forces: FloatArray
    moments: FloatArray
    generalised: FloatArray


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """A motion and the robot that performs it.

    Attributes:
        robot: The robot; coordinates that the file does not contain are locked.
        motion: The motion of the other coordinates.
        locked: Locked coordinates and their positions, in [rad] or [m].
        loads: Measured external loads; None without any.
    """

    robot: Robot
    motion: Motion
    locked: dict[str, float]
    loads: ExternalLoads | None = None


def read_given_motion(
    robot: Robot,
    file: Path,
    noise: float | None = None,
    *,
    begin: float | None = None,
    end: float | None = None,
    frames: int | None = None,
    step: float = 0.0,
) -> GivenMotion:
    """Read a recorded motion of a robot.

    Positions are smoothed and differentiated by a spline of fifth order, see `recorded_trajectory`.

    Args:
        file: Motion file, such as .mot and .sto of OpenSim; see `read_motion`.
        noise: Standard deviation of the position noise (default: estimated from the positions).
        begin: First time, in [s] (default: of the first row).
        end: Last time, in [s] (default: of the last row).
        frames: Number of equidistant times (default: by `step`).
        step: Approximate time between frames by default, in [s]; 0 for the times of the rows.

    Raises:
        InputError: The file has no motion of the robot, or none from `begin` to `end`.
    """
    names = [c.name for c in robot.coordinates]
    lengths = [c.name for c in robot.coordinates if c.unit == "m"]
    recorded = set(recorded_names(file, names, lengths)) or set(names)
    locked = {c.name: c.initial for c in robot.coordinates if c.name not in recorded}
    moving = lock(robot, locked) if locked else robot
    moving_names = Names("coordinate", [c.name for c in moving.coordinates])
    rows, trajectory = read_recorded(file, {"joint": moving_names}, noise, lengths)
    first = float(rows[0]) if begin is None else begin
    last = float(rows[-1]) if end is None else end
    for key, value in (("--begin", first), ("--end", last)):
        if not rows[0] <= value <= rows[-1]:
            problem = f"must be within the motion, {rows[0]:g} to {rows[-1]:g} s, not {value:g}"
            raise InputError(problem, key=key)
    if frames is not None and not 2 <= frames <= MAX_FRAMES:
        raise InputError(f"must be from 2 to {MAX_FRAMES}, not {frames}", key="--frames")
    is_inside = (rows >= first) & (rows <= last)
    if step and frames is None:
        frames = min(max(round((last - first) / step) + 1, 3), MAX_FRAMES)
    times = np.linspace(first, last, frames) if frames else rows[is_inside]
    if len(times) < 2 or first >= last:
        raise InputError(f"contains no two rows from {first:g} to {last:g} s", file=file)
    motion = Motion(times, *SplineReference(trajectory).evaluate(times - rows[0]))
    return GivenMotion(moving, motion, locked)
