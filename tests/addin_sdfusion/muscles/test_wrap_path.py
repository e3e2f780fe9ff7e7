"""Tests of paths over wrap surfaces against closed forms, at any pose."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from addin_sdfusion.muscles.path import path_of
from addin_sdfusion.muscles.rows import PointRow, WrapRow
from addin_sdfusion.muscles.table import MuscleTable
from addin_sdfusion.muscles.wrap_path import path_over
from addin_sdfusion.snapshot import MuscleSnapshot, SurfaceSnapshot, WrapUse


def drawn(a: Any, b: Any, shape: Any = "cylinder", r: float = 1.0, **use: Any) -> np.ndarray:
    """Return the complete path in the frame of the surface, computed in another frame."""
    R, p = Rotation.from_rotvec((0.4, -0.8, 0.3)), np.array((0.5, -2.0, 3.0))
    start, end = (tuple(R.apply(v) + p) for v in (a, b))
    axis = tuple(R.apply((0.0, 0.0, 1.0)))
    face = SurfaceSnapshot("l:1", shape, r, tuple(p), axis, 9.0)
    wrapped = path_over(start, end, face, WrapUse("m", 0, **use))
    points = wrapped.points if wrapped else []
    return np.array([a, *R.inv().apply(np.reshape(points, (-1, 3)) - p), b])


def length(path: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("turns", [0, 2])
def test_sides_and_turns_of_a_cylinder(side: Any, turns: int) -> None:
    """The unrolled path is a straight line, so its length is a hypotenuse."""
    a, b = (-3.0, 0.0, 0.5), (4.0, 0.0, 2.5)
    path = drawn(a, b, side=side, turns=turns)
    middle = path[1:-1]
    assert np.linalg.norm(middle[:, :2], axis=1) == pytest.approx(1.0)
    # A counter-clockwise path about z from -x to +x passes -y.
    assert np.sign(path[1, 1]) == -side
    sweep = math.pi - math.acos(1 / 3) - math.acos(1 / 4) + 2 * math.pi * turns
    flat = math.sqrt(8.0) + math.sqrt(15.0) + sweep
    assert length(path) == pytest.approx(math.hypot(flat, 2.0), rel=1e-3)
    assert np.all(np.diff(path[:, 2]) > 0.0)


def test_shorter_path_and_line_without_contact() -> None:
    a, b = (-3.0, 0.2, 0.0), (3.0, 0.2, 0.0)
    shorter = drawn(a, b)
    assert shorter[1:-1, 1].max() > 0.2
    assert length(shorter) < length(drawn(a, b, side=1))
    assert len(drawn((-3.0, 1.5, 0.0), (3.0, 1.5, 0.0))) == 2
    assert (
        len(drawn((-3.0, 1.5, 0.0), (3.0, 1.5, 0.0), side=-1)) == 2
    )  # the line is already on this side
    assert len(drawn((-3.0, 1.5, 0.0), (3.0, 1.5, 0.0), side=1)) > 10  # around the other side
    assert len(drawn(a, b, inside=True)) == 2
    assert len(drawn((0.5, 0.0, 0.0), b)) == 2  # starts inside the surface


def test_path_over_a_sphere_is_a_great_circle() -> None:
    a, b = np.array((-3.0, 0.3, 0.4)), np.array((2.0, 0.2, 0.5))
    path = drawn(a, b, "sphere")
    assert np.linalg.norm(path[1:-1], axis=1) == pytest.approx(1.0)
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    assert path @ normal == pytest.approx(0.0, abs=1e-9)
    R, S = np.linalg.norm(a), np.linalg.norm(b)
    sweep = math.acos(a @ b / (R * S)) - math.acos(1 / R) - math.acos(1 / S)
    assert length(path) == pytest.approx(
        math.sqrt(R * R - 1) + math.sqrt(S * S - 1) + sweep, rel=1e-3
    )


def table_over(*uses: WrapUse) -> MuscleTable:
    """Return a muscle from (-3, 0, 0.5) to (4, 0, 2.5) over a cylinder of radius 1 about z."""
    face = SurfaceSnapshot("l:1", "cylinder", 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 9.0)
    ends = ((-3.0, 0.0, 0.5), (4.0, 0.0, 2.5))
    return MuscleTable(
        (MuscleSnapshot("m"),),
        tuple(PointRow("via", "l", "m", i, position=p) for i, p in enumerate(ends)),
        wraps=(WrapRow("w", "l", uses, face=face),),
    )


@pytest.mark.parametrize("turns", [0, 1])
def test_the_length_of_a_muscle_includes_its_wraps(turns: int) -> None:
    flat = math.sqrt(8.0) + math.sqrt(15.0) + math.pi - math.acos(1 / 3) - math.acos(1 / 4)
    path = path_of(table_over(WrapUse("m", 0, 1, turns)), "m")
    assert path.length == pytest.approx(math.hypot(flat + 2 * math.pi * turns, 2.0), rel=1e-14)
    assert path.omitted == 0


def test_wraps_that_the_length_does_not_include_are_counted() -> None:
    path = path_of(table_over(WrapUse("m", 0, inside=True)), "m")
    assert path.length == pytest.approx(math.hypot(7.0, 2.0))
    assert path.length_text == "7280.1 mm (1 wraps are not included)"
