"""Recordings of the two-link arm from roll-outs, and markers, for tests of calibrations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from addin_sdfusion.robot import Robot, read_robot
from sim_dart.calibration.markers import Marker
from sim_dart.calibration.recordings import Recording
from sim_dart.calibration.sensitivity import Sensitivity
from sim_dart.core.arrays import FloatArray

from .robots import PLANAR_2R

STEP, ROWS, NOISE = 5e-3, 16, 1e-4

MARKERS = (
    Marker("elbow", "link_1", (0.02, 0.01, 0.9)),
    Marker("wrist", "link_2", (-0.03, 0.02, 0.8)),
    Marker("tip", "link_2", (0.05, -0.01, 1.0)),
)
WORN = np.array([marker.position for marker in MARKERS])


def write_markers(file: Path) -> Path:
    """Write the table of markers for `calibrate`."""
    tables = (f'[{m.name}]\nlink = "{m.link}"\nposition = {list(m.position)}\n' for m in MARKERS)
    file.write_text("\n".join(tables))
    return file


def damped_arm() -> Robot:
    """Return the two-link arm with four cables and damping."""
    robot = read_robot(PLANAR_2R / "robot", "basic")
    joints = tuple(
        replace(j, coordinates=tuple(replace(c, damping=1.0) for c in j.coordinates))
        for j in robot.joints
    )
    return replace(robot, joints=joints)


def roll_out(robot: Robot, start: FloatArray, tensions: FloatArray) -> FloatArray:
    """Return positions and lengths of a roll-out, shape (rows, n + m)."""
    torques = np.zeros((len(tensions), len(robot.coordinates)))
    found = Sensitivity(robot).roll(start, tensions, torques, 1e-3, 5)
    assert found is not None
    return found.readings


def recording(
    robot: Robot,
    offsets: FloatArray,
    seed: int,
    pieces: int = 30,
    noise: float = NOISE,
    rows: int = ROWS,
) -> Recording:
    """Return a recording of short motions from random states, with gaps and noise."""
    rng = np.random.default_rng(seed)
    n, m = len(robot.coordinates), len(robot.muscles)
    q, lengths, tensions = [], [], []
    for _ in range(pieces):
        start = np.concatenate([rng.uniform(-0.5, 0.5, n), rng.uniform(-1.0, 1.0, n)])
        f = rng.uniform(20.0, 22.0, m) * np.ones((rows, 1))
        y = roll_out(robot, start, f)
        y += noise * rng.normal(size=y.shape)
        gap = np.full((1, m), np.nan)
        q += [y[:, :n], gap[:, :n]]
        lengths += [y[:, n:] + offsets, gap]
        tensions += [f, gap]
    q_all = np.vstack(q)
    return Recording(
        "a run", STEP, q_all, np.vstack(lengths), np.vstack(tensions), np.zeros_like(q_all)
    )


def _turned(angle: FloatArray, u: FloatArray) -> FloatArray:
    """Return points rotated about y, shape (rows, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * u[0] + s * u[2], u[1] + 0 * angle, c * u[2] - s * u[0]], axis=1)


def marker_positions(q: FloatArray, worn: FloatArray = WORN) -> FloatArray:
    """Return the closed-form marker positions on the two-link arm, shape (rows, 3 M)."""
    first, second = q[:, 0], q[:, 0] + q[:, 1]
    elbow = _turned(first, np.array([0.0, 0.0, 1.0]))
    return np.hstack([_turned(first, worn[0]), *(elbow + _turned(second, u) for u in worn[1:])])
