"""OpenSim joints over an ellipsoid: positions and rotations agree with their formulas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.oracles.moving_links import MovingLinks

from addin_sdfusion.robot.formats.convert import convert
from addin_sdfusion.robot.formats.read import read
from sim_dart.core.arrays import FloatArray

SPHERE, SPHEROID, ELLIPSOID = "0.07 0.07 0.07", "0.05 0.08 0.08", "0.05 0.08 0.11"


def turn(axis: int, angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = c
    R[j, i], R[i, j] = s, -s
    return R


def model(folder: Path, joint: str, names: str, inner: str) -> Path:
    """Return a model with a body on a joint."""
    coordinates = "".join(f'<Coordinate name="{name}"/>' for name in names.split())
    file = folder / "m.osim"
    file.write_text(
        '<OpenSimDocument Version="40000"><Model name="m"><BodySet><objects><Body name="shank">'
        "<mass>1</mass><inertia>1 1 1 0 0 0</inertia></Body></objects></BodySet><JointSet><objects>"
        f'<{joint} name="knee"><socket_parent_frame>/ground</socket_parent_frame>'
        "<socket_child_frame>/bodyset/shank</socket_child_frame>"
        f"<coordinates>{coordinates}</coordinates>{inner}</{joint}>"
        "</objects></JointSet></Model></OpenSimDocument>"
    )
    return file


@pytest.mark.parametrize("radii", [SPHERE, SPHEROID, ELLIPSOID])
def test_body_moves_over_an_ellipsoid(tmp_path: Path, radii: str) -> None:
    """The body is at the point p whose normal is its z axis n: p = radii * n, by component."""
    inner = f"<radii_x_y_z>{radii}</radii_x_y_z>"
    robot = read(model(tmp_path, "EllipsoidJoint", "a b c", inner)).require()
    sizes = np.array(radii.split(), dtype=float)
    for angles in np.random.default_rng(1).uniform(-2.0, 2.0, (10, 3)):
        at = MovingLinks(robot, dict(zip("abc", angles, strict=True)))
        R = turn(0, angles[0]) @ turn(1, angles[1]) @ turn(2, angles[2])
        place = at.poses["shank"]
        np.testing.assert_allclose(place[:3, :3], R, atol=1e-14)
        np.testing.assert_allclose(place[:3, 3], sizes * R[:, 2], atol=1e-15)
    assert read(convert(robot, "osim", tmp_path / "again").files[0]).require() == robot


def test_scapula_moves_over_the_thorax_with_winging(tmp_path: Path) -> None:
    """OpenSim's ellipsoid frame is rotated by 90 degrees about z, with the winging axis in it."""
    inner = (
        "<thoracic_ellipsoid_radii_x_y_z>0.07 0.15 0.09</thoracic_ellipsoid_radii_x_y_z>"
        "<scapula_winging_axis_origin>0.02 -0.03</scapula_winging_axis_origin>"
        "<scapula_winging_axis_direction>0.4</scapula_winging_axis_direction>"
    )
    robot = read(model(tmp_path, "ScapulothoracicJoint", "a b c d", inner)).require()
    quarter = turn(2, np.pi / 2)
    for a, b, c, d in np.random.default_rng(2).uniform(-1.0, 1.0, (10, 4)):
        at = MovingLinks(robot, {"a": a, "b": b, "c": c, "d": d})
        own = turn(0, a) @ turn(1, b) @ turn(2, c)
        R, p = quarter @ own @ quarter.T, quarter @ (np.array([0.15, 0.07, 0.09]) * own[:, 2])
        origin = np.array([0.02, -0.03, 0.0])
        axes = turn(2, 0.4) @ turn(0, -np.pi / 2)  # its z axis is the winging axis
        winged = axes @ turn(2, d) @ axes.T
        place = at.poses["shank"]
        np.testing.assert_allclose(place[:3, :3], R @ winged, atol=1e-14)
        expected = p + R @ (origin - winged @ origin)
        np.testing.assert_allclose(place[:3, 3], expected, atol=1e-15)
    assert read(convert(robot, "osim", tmp_path / "again").files[0]).require() == robot
