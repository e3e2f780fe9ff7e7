"""Exported masses, inertias, axes and points of seven designs are those of closed forms.

The closed forms are in the root frame: a box and a cylinder for each link, with inertias by the
parallel-axis theorem. The designs differ only in the components that contain them.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_fusion import Builder, designs
from fake_fusion.maths import inverse
from support.designs.exported import Export, export, initial_poses
from support.oracles.loop_model import pose_matrix, skew

DENSITY = 2.7e-3  # [kg/cm³]
SIZE, RADIUS, HEIGHT = (4.0, 6.0, 20.0), 1.5, 9.0  # [cm]
NAMES = ("base", "upper", "lower")
VALUES = (0.4, -0.7)  # [rad]
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
DESIGNS: dict[str, dict[str, Any]] = {
    "rotated": {},
    "nested": {"depth": 3},
    "nested joints": {"depth": 2, "inside": True},
    "as-built": {"as_built": True},
    "nested as-built": {"depth": 2, "as_built": True},
    "joint origins": {"depth": 1, "by_origins": True},
    "mirrored": {"depth": 2, "mirrored": True},
}


class Part:
    """A box and a cylinder in the root frame, as (pose in [m], mass, inertia about the centre)."""

    def __init__(self, box: np.ndarray, cylinder: np.ndarray) -> None:
        a, b, c = 0.01 * np.array(SIZE)
        r, h = 0.01 * RADIUS, 0.01 * HEIGHT
        m_box, m_cylinder = 1e6 * DENSITY * a * b * c, 1e6 * DENSITY * np.pi * r * r * h
        across = m_cylinder * (3 * r * r + h * h) / 12
        self.solids = [
            (box, m_box, m_box / 12 * np.diag([b * b + c * c, a * a + c * c, a * a + b * b])),
            (cylinder, m_cylinder, np.diag([across, across, m_cylinder * r * r / 2])),
        ]
        self.mass = m_box + m_cylinder
        self.com = sum(m * T[:3, 3] for T, m, _ in self.solids) / (100 * self.mass)

    def inertia(self) -> np.ndarray:
        """Return the inertia matrix about the centre of mass, in the root frame."""
        J = np.zeros((3, 3))
        for T, m, own in self.solids:
            R, K = T[:3, :3], skew(0.01 * T[:3, 3] - self.com)
            J += R @ own @ R.T - m * K @ K
        return J


def draw(order: random.Random, *, mirrored: bool = False, **how: Any) -> tuple[Any, Any]:
    """Return the design, and the closed forms: parts, joint frames and points in the root frame."""
    build, depth = Builder("exact"), how.pop("depth", 0)
    inside = how.pop("inside", False)
    above = build.place("assembly", designs.random_motion(order)) if inside else ()
    T_above = above[0].T if inside else np.eye(4)
    side = MIRROR if mirrored else np.eye(4)
    paths, parts, points = [], [], []
    for name in NAMES:
        frame = designs.random_motion(order)
        if inside:
            path = build.place(name, inverse(T_above) @ frame, above=above, grounded=name == "base")
        else:
            path = designs.nested_place(build, name, frame, order, depth, grounded=name == "base")
        box, cylinder = (side @ designs.random_motion(order) @ side for _ in range(2))
        point = side[:3, :3] @ [order.uniform(-30.0, 30.0) for _ in range(3)]
        own = inverse(frame)
        build.box(path, SIZE, own @ box, density=DENSITY)
        build.cylinder(path, RADIUS, HEIGHT, own @ cylinder, density=DENSITY)
        build.point(path, own[:3, :3] @ point + own[:3, 3], f"VP_motor0_EXPORT_{name}_{len(paths)}")
        build.rigid_group(f"EXPORT_{name}", [path])
        paths.append(path)
        parts.append(Part(box, cylinder))
        points.append(0.01 * point)
    frames = []
    for k, value in enumerate(VALUES):
        T = side @ designs.random_motion(order) @ side
        ends, at = (paths[k + 1], paths[k]), inverse(T_above) @ T
        build.joint(f"joint{k}", "revolute", *ends, T=at, values=(value,), inside=above, **how)
        frames.append(T)
    return build.done(), (parts, frames, points)


def errors(made: Export, expected: Any) -> dict[str, float]:
    """Return the relative errors of masses and inertias, and the errors of axes and points."""
    parts, frames, points = expected
    robot, poses = made.robot, initial_poses(made.robot)
    found: dict[str, list[float]] = {"mass": [], "com": [], "inertia": [], "axis": [], "point": []}
    for name, part in zip(NAMES, parts, strict=True):
        own, T = robot.link(name).inertia, poses[name]
        found["mass"].append(abs(own.mass / part.mass - 1.0))
        found["com"].append(np.abs(T @ [*own.com, 1.0] - [*part.com, 1.0]).max())
        J = T[:3, :3] @ np.array(own.matrix) @ T[:3, :3].T
        found["inertia"].append(np.abs(J - part.inertia()).max() / np.abs(part.inertia()).max())
    for k, frame in enumerate(frames):
        joint = robot.joint(f"joint{k}")
        T = poses[joint.parent] @ pose_matrix(joint.T_parent_joint)
        axis, origin = T[:3, :3] @ joint.motions[0].axis, 0.01 * frame[:3, 3]
        found["axis"].append(np.abs(axis - frame[:3, 2]).max())
        off = T[:3, 3] - origin
        found["point"].append(np.abs(off - (off @ axis) * axis).max())  # anywhere on the axis
    for via, point in zip(robot.muscles[0].via_points, points, strict=True):
        found["point"].append(np.abs(poses[via.link] @ [*via.position, 1.0] - [*point, 1.0]).max())
    return {what: float(max(values)) for what, values in found.items()}


LIMITS = {"mass": 1e-15, "com": 1e-15, "inertia": 1e-12, "axis": 2e-15, "point": 2e-15}


@pytest.mark.parametrize("name", DESIGNS)
def test_exported_geometry_and_masses_are_exact(fusion: Any, tmp_path: Path, name: str) -> None:
    order = random.Random(list(DESIGNS).index(name))
    design, expected = draw(order, **DESIGNS[name])
    made = export(design, tmp_path / "robot", visual=False, collision="none")
    found = errors(made, expected)
    assert {what: value for what, value in found.items() if value > LIMITS[what]} == {}
