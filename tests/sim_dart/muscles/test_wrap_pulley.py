"""Swivelling pulleys at the base, as in CASPR."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from support.robots.wrapped import FAR, base_pulley, carriage, vector

from addin_sdfusion.robot import WORLD, Muscle, Robot, ViaPoint
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native
R = 0.05


def caspr_length(F: FloatArray, v: FloatArray, B: FloatArray) -> float:
    """Arc and tangent as CASPR takes them: right for less than half a turn."""
    across = (B - F) - ((B - F) @ v) * v
    C = F + R * across / np.linalg.norm(across)
    n = np.cross(v, across / np.linalg.norm(across))
    rho = R / np.linalg.norm(B - C)
    A = C + rho**2 * (B - C) - rho * math.sqrt(1 - rho**2) * np.cross(n, B - C)
    arc = R * math.acos(np.clip((F - C) @ (A - C) / R**2, -1, 1))
    return float(arc + np.linalg.norm(B - A))


def pulleys(
    rng: np.random.Generator, count: int, kind: Literal["rotating", "screw"] = "rotating"
) -> Robot:
    muscles = [
        Muscle(
            f"muscle_{k}",
            (ViaPoint(WORLD, vector(rng, 0.3)), ViaPoint(FAR, vector(rng, 0.5))),
            pulley=base_pulley(R, vector(rng, 2.0), kind),
        )
        for k in range(count)
    ]
    return carriage(muscles, [])


def numbers(muscle: Muscle) -> tuple[FloatArray, FloatArray, FloatArray]:
    F, B = (np.array(point.position) for point in muscle.via_points)
    assert muscle.pulley is not None
    v = np.array(muscle.pulley.entry_vector)
    return F, v / np.linalg.norm(v), B


@pytest.mark.parametrize("kind", ["rotating", "screw"])
def test_lengths_are_casprs_and_jacobians_their_derivatives(
    kind: Literal["rotating", "screw"],
) -> None:
    """Of a screw's pulley without any travel of its winch."""
    rng = np.random.default_rng(1)
    robot = pulleys(rng, 300, kind)
    paths, compared = MusclePaths(robot), 0
    for _ in range(10):
        q = rng.uniform(-0.3, 0.3, 3)
        lengths, L = (values.copy() for values in paths.evaluate(q))
        for k, muscle in enumerate(robot.muscles):
            F, v, B = numbers(muscle)
            w = B + q - F
            if w @ v > -R and np.linalg.norm(np.cross(w, v)) > 2.5 * R:
                assert lengths[k] == pytest.approx(caspr_length(F, v, B + q), abs=1e-12)
                compared += 1
        for j, e in enumerate(np.eye(3) * 1e-6):
            ahead = paths.evaluate(q + e).lengths.copy()
            slope = (ahead - paths.evaluate(q - e).lengths) / 2e-6
            np.testing.assert_allclose(L[:, j], slope, rtol=0, atol=1e-7)
    assert compared > 1000


def in_plane(x: float, y: float) -> float:
    """Length to a point in the pulley's plane: x along the cable that comes on, y across."""
    ends = (ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(FAR, (x, 0.0, y)))
    muscle = Muscle("m", ends, pulley=base_pulley(R, (2.0, 0.0, 0.0)))
    return float(MusclePaths(carriage([muscle], [])).evaluate(np.zeros(3)).lengths[0])


def test_lengths_in_closed_form() -> None:
    assert in_plane(0.4, 0.0) == pytest.approx(0.4, abs=1e-15)
    assert in_plane(R, 0.4) == pytest.approx(0.5 * math.pi * R + 0.4 - R, abs=1e-14)
    assert in_plane(-0.4, 2 * R) == pytest.approx(math.pi * R + 0.4, abs=1e-14)
    assert in_plane(-R, 0.0) == pytest.approx(1.5 * math.pi * R + R, abs=1e-14)
    inner = 0.5 * R  # the circle through (inner, inner) that touches the entry has this radius
    assert in_plane(inner, inner) == pytest.approx(0.5 * math.pi * inner, abs=1e-14)


@pytest.mark.parametrize("angle", np.radians([10.0, 60.0, 100.0, 170.0]))
def test_an_end_may_come_inside_the_pulley(angle: float) -> None:
    """Without a jump, and finite to its very beginning."""
    edge = 2 * R * math.sin(angle)  # along the chord from the entry point at this angle
    x, y = math.cos(angle), math.sin(angle)
    ahead, behind = (in_plane(d * x, d * y) for d in (edge * (1 + 1e-12), edge * (1 - 1e-12)))
    assert abs(ahead - behind) < 1e-9
    for d in (0.0, 1e-9, 0.3 * edge):
        assert in_plane(d * x, d * y) == pytest.approx(d * angle / math.sin(angle), abs=1e-14)


def test_the_drawn_cable_leaves_along_the_tangent() -> None:
    robot = pulleys(np.random.default_rng(3), 50)
    paths = MusclePaths(robot)
    lengths, lines = paths.evaluate(np.zeros(3)).lengths.copy(), paths.path_points(np.zeros(3))
    for muscle, length, line in zip(robot.muscles, lengths, lines, strict=True):
        F, v, _ = numbers(muscle)
        drawn = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert length * (1 - 4e-4) <= drawn <= length + 1e-12
        first = line[2] - F
        assert first @ v / np.linalg.norm(first) > 0.99
        before, after = line[-2] - line[-3], line[-1] - line[-2]
        cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
        assert cosine > math.cos(math.radians(3.0))


def test_without_its_pulley_the_cable_is_straight() -> None:
    robot = pulleys(np.random.default_rng(4), 20)
    bare = robot.with_muscles(replace(muscle, pulley=None) for muscle in robot.muscles)
    with_pulley = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    assert (with_pulley >= MusclePaths(bare).evaluate(np.zeros(3)).lengths).all()
