"""Tests of lengths and moment arms of moving muscles against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from addin_sdfusion.muscles.motion import SAMPLES, JointSweep
from addin_sdfusion.muscles.rows import PointRow, WrapRow
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.robot.model.joint import Coordinate, Joint, prismatic, revolute
from addin_sdfusion.robot.model.pose import Pose
from addin_sdfusion.robot.model.robot import Inertia, Link, Robot
from addin_sdfusion.snapshot import MuscleSnapshot, SurfaceSnapshot, WrapUse

ORIGIN = np.array((0.1, -0.2, 0.3))


def sweep(axis: Any, initial: float, slides: bool = False) -> JointSweep:
    """Return an arm that moves about or along an axis through `ORIGIN` in the root frame."""
    coordinate = Coordinate("q", -1.5, 2.0, initial, unit="m" if slides else "rad")
    motions = (prismatic if slides else revolute)(axis)
    joint = Joint("q", "base", "arm", motions, (coordinate,), Pose(tuple(ORIGIN)))
    inertia = Inertia.of(1.0, (0.0, 0.0, 0.0), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    links = (Link("base", inertia), Link("arm", inertia))
    robot = Robot("r", links, (Joint("held", "world", "base"), joint))
    return JointSweep(robot, coordinate)


def table(start: Any, end: Any, *wraps: WrapRow) -> MuscleTable:
    ends = (("base", start), ("arm", end))
    points = (PointRow("via", k, "m", i, position=tuple(p)) for i, (k, p) in enumerate(ends))
    return MuscleTable((MuscleSnapshot("m"),), tuple(points), wraps=wraps)


def turned(p: Any, axis: Any, angle: float) -> np.ndarray:
    """Return a point turned about an axis through `ORIGIN` (Rodrigues)."""
    r, a = np.subtract(p, ORIGIN), np.array(axis)
    c, s = math.cos(angle), math.sin(angle)
    return ORIGIN + c * r + s * np.cross(a, r) + (1 - c) * (a @ r) * a


@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (0.6, 0.0, 0.8), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("q", [-1.5, 0.4, 1.0, math.pi / 2, 2.0])
def test_straight_muscle_at_a_hinge(axis: Any, q: float) -> None:
    start, end, initial = np.array((0.3, 0.1, 0.5)), np.array((0.2, 0.4, -0.1)), 0.4
    at = sweep(axis, initial).muscle(table(start, end), "m", q)
    moved = turned(end, axis, q - initial)
    length = np.linalg.norm(moved - start)
    assert at.path.length == pytest.approx(length, rel=1e-12)
    assert at.change == pytest.approx(length - np.linalg.norm(end - start), abs=1e-12)
    arm = np.dot(axis, np.cross(moved - ORIGIN, (start - moved) / length))
    assert at.arm == pytest.approx(arm, abs=1e-8)
    assert len(at.arms) == len(at.plot) == SAMPLES


def test_straight_muscle_at_a_slider() -> None:
    start, end = np.array((0.3, 0.1, 0.5)), np.array((0.2, 0.4, -0.1))
    at = sweep((0.0, 0.0, 1.0), 0.0, slides=True).muscle(table(start, end), "m", 0.2)
    moved = end + np.array((0.0, 0.0, 0.2))
    assert at.arm == pytest.approx((start - moved)[2] / np.linalg.norm(start - moved), abs=1e-8)


@pytest.mark.parametrize("link", ["base", "arm"])
def test_the_arm_over_a_cylinder_on_the_axis_is_its_radius(link: str) -> None:
    """The pulley may turn with either link; after a full turn the muscle always touches it."""
    face = SurfaceSnapshot("a:1", "cylinder", 0.05, tuple(ORIGIN), (0.0, 1.0, 0.0), 1.0)
    wrap = WrapRow("pulley", link, (WrapUse("m", 0, 1, turns=1),), face=face)
    ends = np.array(((0.5, 0.0, 0.0), (-0.4, 0.0, 0.1))) + ORIGIN
    moving = sweep((0.0, 1.0, 0.0), 0.0)
    for q in (-0.5, 0.0, 0.5):
        at = moving.muscle(table(*ends, wrap), "m", q)
        assert abs(at.arm) == pytest.approx(0.05, abs=1e-8)
        assert np.abs(at.arms) == pytest.approx(0.05, abs=1e-8)
    other = moving.muscle(table(*ends), "m", 0.5)  # another table
    assert len(set(other.arms)) == SAMPLES
