from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from support.robots.robots import planar_2r

from addin_sdfusion.robot import Mesh, Pose, Robot
from cardsflow_fmu.results.viewer import Motion, Stage
from cardsflow_fmu.results.viewer.scene import shapes as s
from cardsflow_fmu.results.viewer.scene.meshes import MAX_FACES, link_meshes, simplify


def arm_with(*meshes: Mesh) -> Robot:
    robot = planar_2r()
    return replace(robot, links=(robot.links[0], replace(robot.links[1], meshes=meshes)))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    trimesh.creation.box((0.2, 0.4, 1.0)).export(tmp_path / "box.stl")
    (tmp_path / "broken.stl").write_bytes(b"\0" * 50)
    (tmp_path / "empty.obj").write_text("")
    return tmp_path


def test_mesh_is_placed_and_scaled_in_its_link(folder: Path) -> None:
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


COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="9">0 0 0  1 0 0  0 2 0</float_array><technique_common>
<accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node>
<matrix>0 -1 0 5  1 0 0 6  0 0 1 7  0 0 0 1</matrix><instance_geometry url="#g"/>
</node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_collada_mesh_has_the_pose_of_its_node(tmp_path: Path) -> None:
    """As in published robots: rotation by 90 degrees about z, then translation by 5, 6, 7."""
    (tmp_path / "triangle.dae").write_text(COLLADA)
    meshes = link_meshes(arm_with(Mesh("visual", "triangle.dae", scale=(0.1, 0.1, 0.1))), tmp_path)
    (triangles,) = meshes["link_2"]
    corners = triangles.vertices[triangles.faces[0]]
    np.testing.assert_allclose(corners, [[0.5, 0.6, 0.7], [0.5, 0.7, 0.7], [0.3, 0.6, 0.7]])


@pytest.mark.parametrize(
    "uri", ["missing.stl", "broken.stl", "empty.obj", "", "a\0b", "model://x/y"]
)
def test_link_without_a_readable_mesh_is_drawn_as_capsule(folder: Path, uri: str) -> None:
    robot = arm_with(Mesh("visual", uri), Mesh("visual", "box.stl"))
    assert link_meshes(robot, folder) == {}


def test_collision_meshes_are_not_drawn(folder: Path) -> None:
    assert link_meshes(arm_with(Mesh("collision", "box.stl")), folder) == {}


@pytest.mark.slow
def test_large_mesh_is_simplified_and_keeps_its_shape() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=6, radius=2.0)
    assert len(sphere.faces) > 10 * MAX_FACES
    small = simplify(s.Triangles(np.array(sphere.vertices), np.array(sphere.faces)))
    assert 0.3 * MAX_FACES < len(small.faces) <= MAX_FACES
    np.testing.assert_allclose(np.linalg.norm(small.vertices, axis=1), 2.0, rtol=0.02)
    a, b, c = (small.vertices[small.faces[:, k]] for k in range(3))
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert volume == pytest.approx(4 / 3 * math.pi * 8.0, rel=0.03)


def test_mirrored_mesh_keeps_outward_faces(folder: Path) -> None:
    meshes = link_meshes(arm_with(Mesh("visual", "box.stl", scale=(-1.0, 1.0, 1.0))), folder)
    (triangles,) = meshes["link_2"]
    a, b, c = (triangles.vertices[triangles.faces[:, k]] for k in range(3))
    assert np.sum(a * np.cross(b, c)) / 6.0 == pytest.approx(0.2 * 0.4 * 1.0)
