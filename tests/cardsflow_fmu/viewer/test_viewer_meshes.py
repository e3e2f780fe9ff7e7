from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Mesh, Pose, Robot
from cardsflow_fmu.viewer import Motion, Stage
from cardsflow_fmu.viewer.scene import shapes as s
from cardsflow_fmu.viewer.scene.meshes import MOST_FACES, link_meshes, simplified


def arm_with(*meshes: Mesh) -> Robot:
    robot = planar_2r()
    return replace(robot, links=(robot.links[0], replace(robot.links[1], meshes=meshes)))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    trimesh.creation.box((0.2, 0.4, 1.0)).export(tmp_path / "box.stl")
    (tmp_path / "broken.stl").write_bytes(b"\0" * 50)
    (tmp_path / "empty.obj").write_text("")
    return tmp_path


def test_a_mesh_is_placed_and_scaled_in_its_link(folder: Path) -> None:
    mesh = Mesh(
        "visual", "box.stl", Pose((0.0, 0.0, 0.5), (0.0, 0.0, math.pi / 2)), (0.5, 0.5, 1.0)
    )
    robot = arm_with(mesh)
    meshes = link_meshes(robot, folder)
    assert set(meshes) == {"link_2"}
    shapes = {x.name: x for x in Stage(robot, Motion.still([0.0, math.pi / 2]), meshes).scene(0)}
    assert isinstance(shapes["links/link_1/0"], s.Capsule)
    drawn = shapes["links/link_2/0"]
    assert isinstance(drawn, s.MeshShape)
    corners = drawn.triangles.vertices @ drawn.T[:3, :3].T + drawn.T[:3, 3]
    np.testing.assert_allclose(corners.min(axis=0), [0.0, -0.05, 0.9], atol=1e-7)
    np.testing.assert_allclose(corners.max(axis=0), [1.0, 0.05, 1.1], atol=1e-7)


@pytest.mark.parametrize(
    "uri", ["missing.stl", "broken.stl", "empty.obj", "", "a\0b", "model://x/y"]
)
def test_links_without_a_readable_mesh_stay_capsules(folder: Path, uri: str) -> None:
    robot = arm_with(Mesh("visual", uri), Mesh("visual", "box.stl"))
    assert link_meshes(robot, folder) == {}


def test_collision_meshes_are_not_drawn(folder: Path) -> None:
    assert link_meshes(arm_with(Mesh("collision", "box.stl")), folder) == {}


def test_large_meshes_become_small_and_keep_their_shape() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=6, radius=2.0)
    assert len(sphere.faces) > 10 * MOST_FACES
    small = simplified(s.Triangles(np.array(sphere.vertices), np.array(sphere.faces)))
    assert 0.3 * MOST_FACES < len(small.faces) <= MOST_FACES
    np.testing.assert_allclose(np.linalg.norm(small.vertices, axis=1), 2.0, rtol=0.02)
    a, b, c = (small.vertices[small.faces[:, k]] for k in range(3))
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert volume == pytest.approx(4 / 3 * math.pi * 8.0, rel=0.03)


def test_mirrored_meshes_keep_their_outside(folder: Path) -> None:
    meshes = link_meshes(arm_with(Mesh("visual", "box.stl", scale=(-1.0, 1.0, 1.0))), folder)
    (triangles,) = meshes["link_2"]
    a, b, c = (triangles.vertices[triangles.faces[:, k]] for k in range(3))
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(0.2 * 0.4 * 1.0)
