"""Tests of the convex hull against scipy (Qhull) and the properties of a hull."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from addin_sdfusion.exporting.convex_hull import Hull, convex_hull


def points_of(rows):
    return [tuple(map(float, row)) for row in rows]


def arrays(hull: Hull):
    return np.array(hull.corners), np.array(hull.triangles)


def volume(hull: Hull) -> float:
    corners, triangles = arrays(hull)
    a, b, c = (corners[triangles[:, k]] - corners.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def assert_is_hull(hull: Hull | None, points) -> None:
    assert hull is not None
    corners, triangles = arrays(hull)
    given_ = np.array(points)
    size = np.ptp(given_, axis=0).max()
    edges = {(t[k], t[(k + 1) % 3]) for t in hull.triangles for k in range(3)}
    assert len(edges) == 3 * len(triangles)  # closed: each edge occurs once in each direction
    assert all((b, a) in edges for a, b in edges)
    assert len(corners) - len(edges) // 2 + len(triangles) == 2  # Euler characteristic of a sphere
    assert set(hull.corners) <= set(points)
    mesh = trimesh.Trimesh(corners, triangles, process=False)
    normals = mesh.face_normals[mesh.area_faces > 1e-6 * size**2]
    on = corners[triangles[mesh.area_faces > 1e-6 * size**2][:, 0]]
    for normal, corner in zip(normals, on, strict=True):
        assert ((given_ - corner) @ normal).max() <= 1e-9 * size


RNG = np.random.default_rng(3)
Q = np.linalg.qr(RNG.normal(size=(3, 3)))[0]


def _on_sphere(count):
    v = RNG.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def _prism(sides, height=1.0):
    angle = np.arange(sides) * 2 * math.pi / sides
    rim = np.c_[np.cos(angle), np.sin(angle), np.zeros(sides)]
    return np.vstack([rim, rim + np.array((0, 0, height))])


def _grid(n):
    return np.stack(np.meshgrid(*[np.arange(float(n))] * 3), -1).reshape(-1, 3)


NASTY = {
    "normal": RNG.normal(size=(500, 3)),
    "uniform": RNG.uniform(-1, 1, (500, 3)),
    "on a sphere": _on_sphere(500),
    "grid": _grid(6),
    "turned grid": _grid(6) @ Q.T,
    "prism": _prism(64),
    "turned prism far away": _prism(64) @ Q.T + (10.0, -20.0, 5.0),
    "thin plate": RNG.uniform(-1, 1, (300, 3)) * (1, 1, 1e-4),
    "needle": RNG.uniform(-1, 1, (300, 3)) * (1, 1e-3, 1e-3),
    "many of each": np.repeat(_prism(8), 20, axis=0),
    "faces full of points": np.vstack(
        [
            np.insert(RNG.uniform(-1, 1, (50, 2)), k, side, axis=1)
            for k in range(3)
            for side in (-1, 1)
        ]
        + [2.0 * _grid(2) - 1.0]
    ),
    "tiny": RNG.normal(size=(100, 3)) * 1e-9,
    "huge": RNG.normal(size=(100, 3)) * 1e9,
    "two clusters": np.vstack(
        [RNG.normal(size=(50, 3)) * 1e-5, RNG.normal(size=(50, 3)) * 1e-5 + 1]
    ),
    "tetrahedron": np.eye(4)[:, :3],
}


@pytest.mark.parametrize("name", NASTY)
def test_hull_equals_that_of_qhull(name):
    points = points_of(NASTY[name])
    hull = convex_hull(points)
    assert_is_hull(hull, points)
    middle = NASTY[name].mean(axis=0)  # Qhull loses precision far from the origin
    assert volume(hull) == pytest.approx(ConvexHull(NASTY[name] - middle).volume, rel=1e-9)


def test_flat_faces_have_no_unnecessary_corners():
    for name in ("grid", "faces full of points", "many of each"):
        hull = convex_hull(points_of(NASTY[name]))
        assert hull is not None
        assert len(hull.corners) == (16 if name == "many of each" else 8)


def test_the_volume_of_a_box_is_exact():
    hull = convex_hull([(x, y, z) for x in (0.0, 0.5) for y in (0.0, 0.25) for z in (0.0, 2.0)])
    assert hull is not None
    assert volume(hull) == 0.25
    assert len(hull.triangles) == 12


@pytest.mark.parametrize(
    "rows",
    [
        np.zeros((0, 3)),
        np.zeros((5, 3)),
        [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        np.outer(np.arange(10), (1.0, 2.0, 3.0)),
        np.c_[RNG.uniform(-1, 1, (50, 2)), np.zeros(50)],
        np.c_[RNG.uniform(-1, 1, (50, 2)), np.zeros(50)] @ Q.T + 3.0,
        [[1e-300, 0, 0], [0, 1e-300, 0], [0, 0, 1e-300], [0, 0, 0]],
    ],
    ids=["none", "one", "three", "line", "plane", "turned plane", "next to nothing"],
)
def test_points_without_volume_have_no_hull(rows):
    assert convex_hull(points_of(rows)) is None


def test_the_order_of_the_points_does_not_matter():
    points = points_of(NASTY["turned prism far away"])
    first, again = convex_hull(points), convex_hull(points[::-1])
    assert first is not None
    assert again is not None
    assert first == convex_hull(points)

    def facets(hull):
        return {frozenset(hull.corners[i] for i in triangle) for triangle in hull.triangles}

    assert facets(first) == facets(again)


coordinate = st.one_of(st.integers(-2, 2).map(float), st.floats(-2.0, 2.0))


@given(st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=4, max_size=25))
def test_any_points_have_a_closed_hull_or_no_volume(points):
    hull = convex_hull(points)
    rows = np.array(points)
    if hull is None:
        spread = np.linalg.svd(rows - rows.mean(axis=0))[1]
        assert spread[-1] <= 1e-8 * spread[0] * math.sqrt(len(points)) or spread[0] == 0
    else:
        assert_is_hull(hull, points)


@pytest.mark.cases(1)
@pytest.mark.slow
@pytest.mark.parametrize("name", ["ball", "sphere", "cylinder"])
def test_20000_points_have_a_hull(name):
    rows = {
        "ball": RNG.normal(size=(20_000, 3)),
        "sphere": _on_sphere(20_000),
        "cylinder": _prism(10_000),
    }[name]
    points = points_of(rows)
    assert convex_hull(points) is not None
