"""Tests of enclosing boxes, spheres and cylinders, compared with the same shapes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from support.designs.built_stubs import matrix

from addin_sdfusion.exporting.convex_hull import convex_hull
from addin_sdfusion.exporting.primitives import fit_shape
from addin_sdfusion.robot import Pose, Shape

PLACES = [Pose(), Pose((0.3, -0.2, 0.5), (0.4, 0.9, -1.3)), Pose((5.0, 0.0, 0.0), (1.6, 0.0, 3.0))]


def about(mesh: trimesh.Trimesh, kind: str) -> Shape:
    hull = convex_hull([tuple(p) for p in mesh.vertices])
    assert hull is not None
    nodes = [x for corner in hull.corners for x in corner]
    return fit_shape(kind, nodes, [i for triangle in hull.triangles for i in triangle])


@pytest.mark.parametrize("place", PLACES)
def test_a_box_at_any_pose_is_fitted_exactly(place: Pose) -> None:
    mesh = trimesh.creation.box((0.1, 0.25, 0.4))
    mesh.apply_transform(matrix(place))
    shape = about(mesh, "box")
    np.testing.assert_allclose(sorted(shape.sizes), (0.1, 0.25, 0.4), rtol=1e-9)
    np.testing.assert_allclose(shape.pose.position, place.position, atol=1e-9)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("size", [(0.05, 0.3), (0.2, 0.02), (0.01, 1.0)])
def test_a_cylinder_at_any_pose_is_fitted_exactly(place: Pose, size: tuple[float, float]) -> None:
    mesh = trimesh.creation.cylinder(*size, sections=32)
    mesh.apply_transform(matrix(place))
    shape = about(mesh, "cylinder")
    np.testing.assert_allclose(shape.sizes, size, rtol=1e-9)
    np.testing.assert_allclose(shape.pose.position, place.position, atol=1e-9)
    along = matrix(shape.pose)[:3, 2] @ matrix(place)[:3, 2]
    assert abs(along) == pytest.approx(1.0, abs=1e-9)


def test_a_ball_is_fitted_exactly() -> None:
    mesh = trimesh.creation.icosphere(2, 0.07)
    mesh.apply_translation((1.0, 2.0, 3.0))
    shape = about(mesh, "sphere")
    np.testing.assert_allclose(shape.sizes, (0.07,), rtol=0.01)
    np.testing.assert_allclose(shape.pose.position, (1.0, 2.0, 3.0), atol=1e-3)


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder"])
def test_shapes_enclose_the_body(kind: str) -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        points = rng.normal(size=(30, 3)) * rng.uniform(0.1, 2.0, 3)
        shape = about(trimesh.convex.convex_hull(points), kind)
        T = np.linalg.inv(matrix(shape.pose))
        x, y, z = (points @ T[:3, :3].T + T[:3, 3]).T
        if kind == "box":
            out = max(
                np.abs(a).max() - 0.5 * s for a, s in zip((x, y, z), shape.sizes, strict=True)
            )
        elif kind == "sphere":
            out = np.sqrt(x * x + y * y + z * z).max() - shape.sizes[0]
        else:
            out = max(np.hypot(x, y).max() - shape.sizes[0], np.abs(z).max() - 0.5 * shape.sizes[1])
        assert out < 1e-9
