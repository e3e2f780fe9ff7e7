"""Muscle-muscle and muscle-link interference during a motion: `cardsflow check --motion`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from addin_sdfusion.robot import (
    Coordinate,
    Finding,
    InputError,
    Robot,
    Subject,
    UnknownNameError,
    limits,
)
from addin_sdfusion.robot.formats.read import (
    Reading,
    read_trajectory,
    trajectories_file,
    trajectory_names,
)
from cardsflow_fmu.cosim.signals.port import identifier
from cardsflow_fmu.utils.arrays import FloatArray
from cardsflow_fmu.utils.csv_table import read_csv

if TYPE_CHECKING:
    from sim_dart.dart.interference import Nearest

RANDOM = "random"
_POSTURES = 500
_UNLIMITED_RANGE = {"rad": math.pi, "m": 1.0}  # default range of joints without limits
_TOUCHING = 1e-9  # maximum distance of bodies that touch, in [m]
_NEAR = 1e-3  # distance of muscles that collide, in [m]; paths have no thickness


@dataclass(frozen=True)
class Motion:
    """Postures of a check.

    Attributes:
        postures: Shape (k, n), in [rad] or [m].
        times: Shape (k,), in [s]; None for postures without times.
    """

    postures: FloatArray
    times: FloatArray | None

    def describe(self, robot: Robot, sample: int) -> str:
        """Describe a posture for messages, by its time or its positions."""
        if self.times is not None:
            return f"at t = {self.times[sample]:.4g} s"
        values = zip(robot.coordinates, self.postures[sample], strict=True)
        return "at " + ", ".join(f"{c.name} = {q:.3g} {c.unit}" for c, q in values)


def read_motion(motion: str, reading: Reading, robot: Robot) -> Motion:
    """Read the postures of a motion.

    Args:
        motion: `random`, the name of a trajectory in the folder of the robot, or a table with a
            column `q.<joint>` or `<joint>` for every joint, such as the results.csv of a run.

    Raises:
        InputError: The motion does not exist or does not match the robot.
    """
    if motion == RANDOM:
        return Motion(_random_postures(robot), None)
    if motion.endswith(".csv"):
        return _table(Path(motion), robot)
    return _trajectory(motion, reading, robot)


def _random_postures(robot: Robot) -> FloatArray:
    """Return reproducible random postures within the joint limits."""
    limits = np.array([_limits(c) for c in robot.coordinates]).reshape(-1, 2)
    low, high = limits[:, 0], limits[:, 1]
    postures: FloatArray = np.random.default_rng(0).uniform(low, high, (_POSTURES, len(limits)))
    return postures


def _limits(coordinate: Coordinate) -> tuple[float, float]:
    """Return the limits of a coordinate; infinite limits are replaced by a default range."""
    lower, upper, default = coordinate.lower, coordinate.upper, _UNLIMITED_RANGE[coordinate.unit]
    return (
        lower if math.isfinite(lower) else min(-default, upper - 2 * default),
        upper if math.isfinite(upper) else max(default, lower + 2 * default),
    )


def _trajectory(name: str, reading: Reading, robot: Robot) -> Motion:
    from controllers import SplineReference

    file = trajectories_file(reading.files[0])
    if file is None:
        problem = f"{name!r} is neither {RANDOM!r} nor a .csv file, and the folder of"
        problem += f" {reading.files[0]} has no trajectories file"
        raise InputError(problem, key="--motion")
    try:
        trajectory = read_trajectory(file, name)
    except UnknownNameError:
        raise UnknownNameError(
            "trajectory", name, [*trajectory_names(file), RANDOM], key="--motion"
        ) from None
    if len(trajectory.points[0].q) != len(robot.coordinates):
        raise InputError(f"{name!r} does not move all joints of the robot", key="--motion")
    times = np.linspace(0.0, trajectory.points[-1].time, _POSTURES)
    return Motion(SplineReference(trajectory).evaluate(times).q, times)


def _table(file: Path, robot: Robot) -> Motion:
    names, rows = read_csv(file, kind="table of joint positions", most=limits.MOTION_VALUES)
    if not len(rows):
        raise InputError("has no rows", file=file)
    postures = rows[:, [_column(c.name, names, file) for c in robot.coordinates]]
    wrong = np.flatnonzero(~np.isfinite(postures).all(axis=1))
    if wrong.size:
        problem = "contains a value that is not finite"
        raise InputError(problem, file=file, line=int(wrong[0]) + 2)
    return Motion(postures, rows[:, names.index("time")] if "time" in names else None)


def _column(joint: str, names: Sequence[str], file: Path) -> int:
    for name in (f"q.{identifier(joint)}", joint):
        if name in names:
            return names.index(name)
    raise UnknownNameError("column", f"q.{identifier(joint)}", names, file=file, line=1)


def motion_findings(
    reading: Reading, robot: Robot, motion: str, clearance: float, capsule_radius: float | None
) -> list[Finding]:
    """Return a warning for each pair of bodies whose distance is less than the clearance.

    Args:
        motion: See `read_motion`.
        clearance: Minimum distance, in [m].
        capsule_radius: Radius of capsules that replace the links, in [m]; None for the convex hulls
            of the collision meshes.

    Raises:
        InputError: The motion, the clearance or a mesh is invalid.
    """
    from sim_dart.dart.interference import Interference
    from sim_dart.scene import Scene

    if not (math.isfinite(clearance) and clearance >= 0):
        raise InputError(f"must be finite and not negative, not {clearance!r}", key="--clearance")
    folder = reading.files[0].parent.resolve()
    if capsule_radius is None:
        scene = Scene(mesh_folder=folder)
    else:
        scene = Scene(links="capsules", capsule_radius=capsule_radius)
    postures = read_motion(motion, reading, robot)
    findings = []
    for near in Interference(robot, scene).nearest(postures.postures, clearance):
        if near.distance > clearance:
            break
        message = f"{_description(near)} {postures.describe(robot, near.sample)}"
        code = "muscle-meets-link" if near.is_link else "muscle-meets-muscle"
        findings.append(Finding("warning", code, message, Subject("muscle", near.muscle)))
    return findings


def new_collisions(robot: Robot, mesh_folder: Path, postures: FloatArray) -> list[str]:
    """Describe collisions of muscles with muscles or links that are not present at the start.

    Args:
        mesh_folder: Folder of the collision meshes. If a mesh is invalid, only muscles are checked.
        postures: The motion, shape (k, n), in [rad] or [m].

    Returns:
        One line for each pair of bodies.
    """
    from sim_dart.dart.interference import Interference
    from sim_dart.scene import Scene

    try:
        pairs = Interference(robot, Scene(mesh_folder=mesh_folder))
    except InputError:
        pairs = Interference(robot, Scene(links="none"))
    initial = {(n.muscle, n.other): n.distance for n in pairs.nearest(postures[:1])}
    return [
        _description(near)
        for near in pairs.nearest(postures, _NEAR)
        if near.distance <= _NEAR < initial.get((near.muscle, near.other), 0.0)
    ]


def _description(near: Nearest) -> str:
    if near.is_link and near.distance < 0:
        contact = f"passes {-1e3 * near.distance:.3g} mm deep through link {near.other!r}"
    else:
        kind = "link" if near.is_link else "muscle"
        apart = f"{1e3 * near.distance:.3g} mm" if near.distance > _TOUCHING else "touch"
        contact = f"comes within {apart} of {kind} {near.other!r}"
    return f"muscle {near.muscle!r} {contact}"
