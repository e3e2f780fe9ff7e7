"""Swivelling pulleys at the base, as in CASPR."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from support.robots.muscle_bench import WINCH
from support.robots.wrapped import FAR, base_pulley, carriage, vector

from addin_sdfusion.robot import (
    WORLD,
    CableModel,
    CableSet,
    Coordinate,
    Inertia,
    Joint,
    Link,
    Muscle,
    Robot,
    ViaPoint,
    prismatic,
    revolute,
)
from addin_sdfusion.robot.model.joint import Motion
from addin_sdfusion.robot.model.muscle_laws import muscle_parameters
from addin_sdfusion.robot.model.muscle_path import Branch
from sim_dart import MusclePaths
from sim_dart.core.arrays import FloatArray

pytestmark = pytest.mark.native
R = 0.05


def caspr_length(F: FloatArray, v: FloatArray, B: FloatArray) -> float:
    """Return arc plus tangent as in CASPR, valid for less than half a turn."""
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["rotating", "screw"])
def test_lengths_equal_caspr_and_jacobians_their_derivatives(
    kind: Literal["rotating", "screw"],
) -> None:
    """The pulley of a screw has no travel."""
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
    """Return the length to a point in the pulley plane, with x along the incoming cable."""
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
def test_end_point_inside_the_pulley(angle: float) -> None:
    """The length is continuous and finite up to the entry point."""
    edge = 2 * R * math.sin(angle)  # along the chord from the entry point at this angle
    x, y = math.cos(angle), math.sin(angle)
    ahead, behind = (in_plane(d * x, d * y) for d in (edge * (1 + 1e-12), edge * (1 - 1e-12)))
    assert abs(ahead - behind) < 1e-9
    for d in (0.0, 1e-9, 0.3 * edge):
        assert in_plane(d * x, d * y) == pytest.approx(d * angle / math.sin(angle), abs=1e-14)


def test_drawn_cable_leaves_along_the_tangent() -> None:
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


def test_cable_without_pulley_is_straight() -> None:
    robot = pulleys(np.random.default_rng(4), 20)
    bare = robot.with_muscles(replace(muscle, pulley=None) for muscle in robot.muscles)
    with_pulley = MusclePaths(robot).evaluate(np.zeros(3)).lengths
    assert (with_pulley >= MusclePaths(bare).evaluate(np.zeros(3)).lengths).all()


def test_pulley_on_a_link() -> None:
    """The same cable has its pulley on the carriage and its end in the world."""
    rng = np.random.default_rng(5)
    robot = pulleys(rng, 40)
    turned = robot.with_muscles(
        replace(
            m, via_points=(replace(m.via_points[0], link=FAR), replace(m.via_points[1], link=WORLD))
        )
        for m in robot.muscles
    )
    for q in rng.uniform(-0.3, 0.3, (5, 3)):
        there, here = MusclePaths(robot).evaluate(q), MusclePaths(turned).evaluate(-q)
        np.testing.assert_allclose(here.lengths, there.lengths, rtol=1e-13)
        np.testing.assert_allclose(here.jacobian, -there.jacobian, rtol=0, atol=1e-12)


def test_winch_includes_inertia_and_friction_of_its_pulley() -> None:
    """The drum has the additional inertia J (r / R)^2 and friction Tc r / R."""
    pulley = base_pulley(R, (1.0, 0.0, 0.0))
    given = (("inertia", (3e-4,)), ("bearing_friction", (0.02,)))
    law = CableModel("winch", (*WINCH.items(), ("drum_inertia", 1e-3)))
    ends = (ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(FAR, (0.3, 0.0, 0.1)))
    muscle = Muscle("m", ends, 0.0, 9.0, law, replace(pulley, parameters=pulley.parameters + given))
    values, ratio = muscle_parameters(muscle), WINCH["drum_radius"] / R
    assert values["drum_inertia"] == pytest.approx(1e-3 + 3e-4 * ratio**2, rel=1e-15)
    assert values["dry_friction"] == pytest.approx(WINCH["dry_friction"] + 0.02 * ratio, rel=1e-15)


CORNERS = [(x, y, z) for z in (-1.0, 1.0) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
PLATFORMS = {
    # pulleys at the corners of a frame, above and below; cables to the corners of a box
    "like IPAnema": [
        ((4.0 * x, 3.0 * y, 2.0 + 2.0 * z), (0.3 * x, 0.2 * y, 0.1 * z)) for x, y, z in CORNERS
    ],
    # all pulleys above, two a corner; cables cross to the far edges of a box
    "like CoGiRo": [
        ((7.0 * x + 0.5 * z, 5.5 * y, 5.5 + 0.1 * z), (-0.5 * x * z, 0.5 * y, 0.5 * z))
        for x, y, z in CORNERS
    ],
}


@pytest.mark.parametrize("name", PLATFORMS)
def test_platforms_with_swivelling_pulleys_in_closed_form(name: str) -> None:
    """Compare lengths to 1e-12 m, and wrenches of unit tensions with forces along tangents."""
    free = Joint("free", WORLD, "platform", *_spatial())
    muscles = [
        Muscle(f"c{k}", (ViaPoint(WORLD, F), ViaPoint("platform", b)), 1.0, 100.0,
               pulley=base_pulley(R, (0.0, 0.0, 1.0 if F[2] < 1.0 else -1.0)))
        for k, (F, b) in enumerate(PLATFORMS[name])
    ]  # fmt: skip
    link = Link("platform", Inertia(10.0, (0.0, 0.0, 0.0), 1.0, 1.0, 1.0))
    robot = Robot("p", (link,), (free,), (CableSet("all", tuple(muscles)),), "all")
    paths, rng = MusclePaths(robot), np.random.default_rng(6)
    for _ in range(20):
        q = rng.uniform(-1, 1, 6) * [1, 1, 1, 0.3, 0.3, 0.3] + [0, 0, 2, 0, 0, 0]
        turned = Rotation.from_euler("XYZ", q[3:]).as_matrix()
        for k, length in enumerate(paths.evaluate(q).lengths):
            F, v, b = numbers(muscles[k])
            assert length == pytest.approx(caspr_length(F, v, q[:3] + turned @ b), abs=1e-12)


def _spatial() -> tuple[tuple[Motion, ...], tuple[Coordinate, ...]]:
    axes = [tuple(row) for row in np.eye(3).tolist()]
    motions = [*(prismatic(a)[0] for a in axes), *(revolute(a)[0] for a in axes)]
    driven = tuple(replace(motion, coordinate=k) for k, motion in enumerate(motions))
    names = [Coordinate(f"q{k}", -9.0, 9.0, unit="m" if k < 3 else "rad") for k in range(6)]
    return driven, tuple(names)


def test_tackle_pulls_with_every_fall() -> None:
    """A path with n falls has n times the length and n times the force."""
    fall = (ViaPoint(WORLD, (0.0, 0.0, 0.0)), ViaPoint(FAR, (0.5, 0.2, 0.1)))
    tackles = [Muscle(f"n{n}", tuple(fall[k % 2] for k in range(n + 1))) for n in (1, 2, 3, 6)]
    state = MusclePaths(carriage(tackles, [])).evaluate(np.array([0.1, 0.2, -0.1]))
    for n, length, row in zip((1, 2, 3, 6), state.lengths, state.jacobian, strict=True):
        assert length == pytest.approx(n * state.lengths[0], rel=1e-14)
        np.testing.assert_allclose(row, n * state.jacobian[0], rtol=1e-13)


def test_differential_pulley_force_depends_on_difference_of_radii() -> None:
    """In Weston's pulley, sheaves of radius R and r < R are on the same axle."""
    up, load = ViaPoint(WORLD, (0.0, 0.0, 1.0)), ViaPoint(FAR, (0.0, 0.0, 0.0))
    down = Branch(2, -10.0 / 9.0)  # r / R = 0.9
    muscle = Muscle("w", (up, load, up, load), branches=(down,))
    plain = Muscle("p", (up, load))
    state = MusclePaths(carriage([muscle, plain], [])).evaluate(np.array([0.0, 0.1, 0.2]))
    np.testing.assert_allclose(state.jacobian[0], 0.1 * state.jacobian[1], rtol=1e-12, atol=1e-16)
